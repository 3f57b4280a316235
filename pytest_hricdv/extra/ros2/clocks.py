"""Simulates the clocks and timers of `rclpy`: clocks of all three kinds read the virtual time of the run's `Kernel`.

`extension` gives `rclpy` the classes `Clock`, `RosTimer`, `TimePoint` and `Duration`. `system_ns` is the time that
nodes read from the system's clock, with which the fakes of `kit` stamp messages.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Any
from weakref import WeakSet

from pytest_hricdv.extra.ros2.contexts import Context
from pytest_hricdv.extra.ros2.handles import Destroyable, RCLError, Waitable, current_kernel
from pytest_hricdv.runtime.kernel import US_PER_S, Kernel, Node, current_node
from pytest_hricdv.runtime.virtual.clocks import EPOCH

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

_BOOT_NS = 3600 * 1_000_000_000
"""The steady clock's time when a run begins: positive, so that earlier times are not below 0."""

EPOCH_NS = round(EPOCH.timestamp()) * 1_000_000_000
"""The system clock's time when a run begins (ns since 1970)."""


def whole_ns(duration_s: float) -> int:
    """A duration in whole ns: at least 1 ns if it is above 0.

    `rclpy` truncates it to 0 ns, and polls until the duration is over; in a run, no time would pass between two polls.
    """
    return max(int(duration_s * 1e9), 1) if duration_s > 0 else int(duration_s * 1e9)


def system_ns(kernel: Kernel) -> int:
    """The time of the system's clock (ns since 1970)."""
    return EPOCH_NS + kernel.now_us * 1000


_WITHOUT_CLOCK_TOPIC = "ros2 without /clock"  # key of `Kernel.own`


def need_no_clock_topic(kernel: Kernel) -> None:
    """Let clocks with `use_sim_time` read the kernel until there is a message on `/clock`, instead of showing 0."""
    kernel.own[_WITHOUT_CLOCK_TOPIC] = True


class TimerCancelledError(RCLError):
    """Like the error of `rclpy`'s extension: a timer that is cancelled was called."""


class ClockType(IntEnum):
    """The kinds of clocks, numbered like `rcl_clock_type_t`."""

    UNINITIALIZED = 0
    ROS_TIME = 1
    SYSTEM_TIME = 2
    STEADY_TIME = 3


class ClockChange(IntEnum):
    """How the source of a ROS clock's time changed, numbered like `rcl_clock_change_t`."""

    ROS_TIME_NO_CHANGE = 1
    ROS_TIME_ACTIVATED = 2
    ROS_TIME_DEACTIVATED = 3
    SYSTEM_TIME_NO_CHANGE = 4


@dataclass
class TimePoint:
    """Like `rcl_time_point_t`: a moment of a clock."""

    nanoseconds: int
    clock_type: Any


@dataclass
class Duration:
    """Like `rcl_duration_t`."""

    nanoseconds: int


@dataclass(frozen=True)
class _Jump:
    """A callback for jumps of a clock, and the jumps that it is for."""

    handle: Any
    on_change: bool
    min_forward_ns: int
    min_backward_ns: int

    def concerns(self, change: ClockChange, delta_ns: int) -> bool:
        if change in (ClockChange.ROS_TIME_ACTIVATED, ClockChange.ROS_TIME_DEACTIVATED):
            return self.on_change
        forward = self.min_forward_ns != 0 and delta_ns >= self.min_forward_ns
        return forward or (self.min_backward_ns != 0 and delta_ns <= self.min_backward_ns)


class Clock(Destroyable):
    """Like `rcl_clock_t`. A ROS clock that is overridden stands still between two settings (design of ROS time)."""

    def __init__(self, clock_type: int, kernel: Kernel | None = None) -> None:
        node = current_node()
        # Neither is given for a clock that rclpy has in a class.
        super().__init__(kernel if kernel is not None or node is None else node.kernel)
        self.type = ClockType(clock_type)
        self._is_overridden = False
        self._override_ns: int | None = None
        self._jumps: list[_Jump] = []
        self.waiting: list[Node] = []
        """The nodes that wait for a timer of this clock."""
        self.timers: WeakSet[RosTimer] = WeakSet()
        """The timers of this clock."""

    def now_ns(self) -> int:
        """The time (ns since 1970, or of a steady clock since the machine was switched on).

        An overridden clock that was not set reads the kernel: simulated time needs no publisher of `/clock`.
        """
        set_ns = self._set_ns() if self._is_overridden else None
        if set_ns is not None:
            return set_ns
        is_steady = self.type is ClockType.STEADY_TIME
        return _BOOT_NS + self.kernel.now_us * 1000 if is_steady else system_ns(self.kernel)

    def get_now(self) -> TimePoint:
        """The time; in a loop that only reads it, it passes."""
        self.kernel.count_clock_read()
        return TimePoint(self.now_ns(), self.type)

    def stands_still(self) -> bool:
        """Whether its time passes only when it is set."""
        return self._is_overridden and self._set_ns() is not None

    def _set_ns(self) -> int | None:
        """The time that it was set to; None if it was not. `rclpy` sets 0 until there is a message on `/clock`."""
        is_awaited = not self._override_ns and self.kernel.own.get(_WITHOUT_CLOCK_TOPIC, False)
        return None if is_awaited else self._override_ns

    def get_ros_time_override_is_enabled(self) -> bool:
        self._require_ros()
        return self._is_overridden

    def set_ros_time_override_is_enabled(self, enabled: bool) -> None:
        """Override it, or let it be the system's again."""
        self._require_ros()
        before = self._is_overridden
        if before == enabled:
            change = ClockChange.ROS_TIME_NO_CHANGE if enabled else ClockChange.SYSTEM_TIME_NO_CHANGE
        else:
            change = ClockChange.ROS_TIME_ACTIVATED if enabled else ClockChange.ROS_TIME_DEACTIVATED
        concerned = self._before_jump(change, 0)
        self._is_overridden = enabled
        self._after_jump(concerned, change, 0)

    def set_ros_time_override(self, time_point: TimePoint) -> None:
        """Set the time that it has while it is overridden."""
        self._require_ros()
        if not self._is_overridden:
            self._override_ns = time_point.nanoseconds
            return
        delta_ns = time_point.nanoseconds - (self._override_ns or 0)
        concerned = self._before_jump(ClockChange.ROS_TIME_NO_CHANGE, delta_ns)
        self._override_ns = time_point.nanoseconds
        if delta_ns < 0:
            for timer in self.timers:
                timer.notice_jump()
        self._after_jump(concerned, ClockChange.ROS_TIME_NO_CHANGE, delta_ns)

    def add_clock_callback(self, handle: Any, on_clock_change: bool, min_forward: int, min_backward: int) -> None:
        """Call the callbacks of `handle` at jumps of at least these sizes (ns)."""
        self._jumps.append(_Jump(handle, on_clock_change, min_forward, min_backward))

    def remove_clock_callback(self, handle: Any) -> None:
        """Tell it no more."""
        kept = [jump for jump in self._jumps if jump.handle is not handle]
        if len(kept) == len(self._jumps):
            raise RCLError("failed to remove time jump callback: jump callback was not found")
        self._jumps = kept

    def _before_jump(self, change: ClockChange, delta_ns: int) -> list[_Jump]:
        concerned = [jump for jump in self._jumps if jump.concerns(change, delta_ns)]
        for jump in concerned:
            if jump.handle._pre_callback is not None:
                jump.handle._pre_callback()
        return concerned

    def _after_jump(self, concerned: list[_Jump], change: ClockChange, delta_ns: int) -> None:
        for jump in concerned:
            if jump.handle._post_callback is not None:
                jump.handle._post_callback({"clock_change": change, "delta": delta_ns})
        for node in self.waiting:
            self.kernel.wake(node)

    def _require_ros(self) -> None:
        if self.type is not ClockType.ROS_TIME:
            raise RCLError(f"clock is not of type ROS_TIME, but {self.type.name}")


class ClockEvent(Waitable):
    """Like that of the extension: the event that a sleep of a clock waits for; setting it ends the sleep at once."""

    def __init__(self) -> None:
        super().__init__(current_kernel("ClockEvent"))
        self._is_set = False

    def is_set(self) -> bool:
        return self._is_set

    is_ready = is_set

    def set(self) -> None:
        """Set it, and wake its waiters."""
        self._is_set = True
        self.wake()

    def clear(self) -> None:
        self._is_set = False

    def _wait_until(self, clock: Clock, until: TimePoint) -> None:
        """Block until the clock has a time, or this is set; a clock that stands still has it when somebody sets it."""
        node = self.kernel.current()
        queues = (self.waiting, clock.waiting)
        for queue in queues:
            queue.append(node)
        try:
            while not self._is_set and (left_ns := until.nanoseconds - clock.now_ns()) > 0:
                self.kernel.block(None if clock.stands_still() else -(-left_ns // 1000) / US_PER_S)
        finally:
            for queue in queues:
                queue.remove(node)

    wait_until_steady = _wait_until
    wait_until_system = _wait_until
    wait_until_ros = _wait_until


class RosTimer(Waitable):
    """Like `rcl_timer_t`: due each period of its clock; what was missed is skipped, and the phase is kept.

    Raises:
        RCLError: a negative period, or the context is shut down.
    """

    def __init__(self, clock: Clock, context: Context, period_nsec: int, autostart: bool = True) -> None:
        super().__init__(clock.kernel)
        context.require_valid("create timer")
        if period_nsec < 0:
            raise RCLError(f"failed to create timer: timer period must be non-negative, is {period_nsec} ns")
        self._clock = clock
        clock.timers.add(self)
        self._period_ns = period_nsec
        self._last_ns = clock.now_ns()
        self._next_ns = self._last_ns + period_nsec
        self._canceled = not autostart

    def is_ready(self) -> bool:
        return not self._canceled and self._next_ns <= self._clock.now_ns()

    is_timer_ready = is_ready

    def came(self) -> tuple[int, int]:
        """When it was due; timers come first within an instant."""
        return self.kernel.now_us * 1000 + min(self._next_ns - self._clock.now_ns(), 0), 0

    def due_ns(self) -> int | None:
        """When it is due, in the kernel's time; None if it is cancelled, or its clock stands still."""
        if self._canceled or self._clock.stands_still():
            return None
        return self.kernel.now_us * 1000 + self._next_ns - self._clock.now_ns()

    @property
    def clock(self) -> Clock:
        return self._clock

    def call_timer(self) -> None:
        """Count one call. Raises TimerCancelledError for one that is cancelled."""
        self.call_timer_with_info()

    def call_timer_with_info(self) -> dict[str, int]:
        """Count one call; returns when it was expected, and when it came (ns)."""
        if self._canceled:
            raise TimerCancelledError("failed to call timer: timer is canceled")
        now_ns, expected_ns = self._clock.now_ns(), self._next_ns
        self._last_ns = now_ns
        self._next_ns += self._period_ns
        # As in rcl, missed periods are skipped, so that the next call is in phase with the first.
        if self._next_ns <= now_ns and self._period_ns:
            self._next_ns += ((now_ns - self._next_ns) // self._period_ns + 1) * self._period_ns
        if not self._period_ns:
            self._next_ns = now_ns + 1  # it is due as often as the machine can call it: time has to pass meanwhile
        return {"expected_call_time": expected_ns, "actual_call_time": now_ns}

    def notice_jump(self) -> None:
        """Restart the period if the clock was set back before the last call."""
        now_ns = self._clock.now_ns()
        if now_ns < self._last_ns:
            self._last_ns, self._next_ns = now_ns, now_ns + self._period_ns

    def reset_timer(self) -> None:
        """Restart the period, also of a cancelled timer."""
        self._next_ns = self._clock.now_ns() + self._period_ns
        self._canceled = False
        self._note_arrival()

    set_on_reset_callback = Waitable.set_callback
    clear_on_reset_callback = Waitable.clear_callback

    def cancel_timer(self) -> None:
        self._canceled = True

    def is_timer_canceled(self) -> bool:
        return self._canceled

    def change_timer_period(self, period_nsec: int) -> None:
        """Set the period from the next call on."""
        self._period_ns = period_nsec

    def get_timer_period(self) -> int:
        return self._period_ns

    def time_until_next_call(self) -> int | None:
        """The time until it is due (ns, negative if it is late); None when it is cancelled."""
        return None if self._canceled else self._next_ns - self._clock.now_ns()

    def time_since_last_call(self) -> int:
        """The time since its last call, or its creation (ns)."""
        return self._clock.now_ns() - self._last_ns
