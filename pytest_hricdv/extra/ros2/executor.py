"""Lets executors of `rclpy` check which entities are ready, instead of building a wait set for each callback.

`overlay` calls `check_entities_when_waiting` once `rclpy.executors` is imported; `events_executor` makes the newer
`EventsExecutor`. `rclpy` spends most of its time building wait sets (rclpy#1461). Here an executor blocks in the kernel
while none of its entities is ready, and is woken when one becomes ready. While coroutines are in progress, it waits as
`rclpy` does. The callbacks and their order are the same.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.extra.ros2.clocks import RosTimer, whole_ns
from pytest_hricdv.extra.ros2.handles import InvalidHandle, Waitable, current_kernel
from pytest_hricdv.extra.ros2.wait_set import WaitSet, block_until_woken

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

Ready = tuple[Any, Any, Any]
"""An entity, its node, and the method of the executor that takes its data."""

_PLAIN = (
    ("timers", "_take_timer"),
    ("subscriptions", "_take_subscription"),
    ("guards", "_take_guard_condition"),
    ("clients", "_take_client"),
    ("services", "_take_service"),
)
"""Entities of nodes, in the order in which `rclpy` checks them -> how an executor takes their data."""

# The methods of `Executor` that this module replaces or calls
_USED = ("_wait_for_ready_callbacks", "_make_handler", *(take for _, take in _PLAIN), "_take_waitable")


def check_entities_when_waiting(executors: Any) -> None:
    """Patch `Executor` in the module `rclpy.executors`, once, and only if it has all methods in `_USED`."""
    # Checked by name: `rclpy` changes such methods between distributions, and is slower but right without this.
    kind = getattr(executors, "Executor", None)  # the module may be in the middle of its import
    if (
        kind is not None
        and all(hasattr(kind, name) for name in _USED)
        and kind._wait_for_ready_callbacks.__module__ != __name__
    ):
        kind._wait_for_ready_callbacks = _replacement(executors, kind._wait_for_ready_callbacks)


def _replacement(executors: Any, original: Callable[..., Any]) -> Callable[..., Any]:
    """The replacement of the method."""

    def wait_for_ready_callbacks(
        self: Any, timeout_sec: Any = None, nodes: Any = None, condition: Callable[[], bool] = lambda: False
    ) -> Iterator[tuple[Any, Any, Any]]:
        if self._context.handle is not None:
            self._context.handle.require_valid("initialize wait set")
        end_ns = _end_ns(timeout_sec)
        has_work = False
        while not has_work and not self._is_shutdown and not condition():
            with self._tasks_lock:
                self._tasks = [task for task in self._tasks if not task[0].done()]
            if self._tasks:
                yield from original(self, _left_s(end_ns), nodes, condition)
                return
            entities = Entities(self, self.get_nodes() if nodes is None else nodes)
            ready, is_over = entities.wait(end_ns)
            if self._is_shutdown:
                raise executors.ShutdownException
            if not self._context.ok():
                raise executors.ExternalShutdownException
            # Check again: the callback before this one may have taken the group, or cancelled the timer.
            for entity, node, take in _in_order(ready):
                if self.can_execute(entity) and _is_still(entity):
                    has_work = True
                    yield self._make_handler(entity, node, take), entity, node
            if is_over:
                raise executors.TimeoutException
        if self._is_shutdown:
            raise executors.ShutdownException
        if condition():
            raise executors.ConditionReachedException

    return wait_for_ready_callbacks


def _in_order(ready: list[Ready]) -> Iterator[Ready]:
    """The ready entities, in the order of the run's schedule."""
    kernel = current_kernel("spin")
    while ready:
        yield ready.pop(kernel.choose(len(ready)))


def _end_ns(timeout_sec: Any) -> int | None:
    """The end of a time-out (ns of simulated time); None: never. The time-out is in s, or an object that has it."""
    timeout_s = getattr(timeout_sec, "timeout", timeout_sec)
    if timeout_s is None or timeout_s < 0:
        return None
    return current_kernel("spin").now_us * 1000 + whole_ns(float(timeout_s))


def _left_s(end_ns: int | None) -> float | None:
    """Remaining time (s) of a time-out; None: for ever."""
    return None if end_ns is None else max(end_ns - current_kernel("spin").now_us * 1000, 0) / 1e9


def _is_still(entity: Any) -> bool:
    """Whether a timer was not cancelled or reset by a callback that came first; of others, it is so."""
    handle = getattr(entity, "handle", None)
    return handle.is_ready() if isinstance(handle, RosTimer) else True


@dataclass
class _Waitables:
    """Some waitables, and a wait set that has what they wait for."""

    waitables: list[Any]
    wait_set: WaitSet

    @classmethod
    def of(cls, waitables: Sequence[Any]) -> _Waitables:
        wait_set, kept = WaitSet(), []
        for waitable in waitables:
            try:
                with waitable:
                    waitable.add_to_wait_set(wait_set)
            except InvalidHandle:
                continue  # destroyed
            kept.append(waitable)
        return cls(kept, wait_set)


class Entities:
    """The entities of some nodes of `rclpy` that an executor waits for now."""

    def __init__(self, executor: Any, nodes: Sequence[Any]) -> None:
        self._executor = executor
        self._nodes = nodes
        self._plain = [
            (entity, node, getattr(executor, take), entity.handle)
            for node in nodes
            for kind, take in _PLAIN
            for entity in getattr(node, kind)
            if not entity.handle.is_destroyed
        ]
        self._owners = {waitable: node for node in nodes for waitable in node.waitables}
        self._waitables = self._reuse_waitables()
        self._guards: list[Waitable] = [guard.handle for guard in (executor._guard, executor._sigint_gc) if guard]

    def _reuse_waitables(self) -> _Waitables:
        """The last waitables, if they are the same and none can wait for something else now."""
        every = list(self._owners)
        kept = vars(self._executor).get("_waitables")
        if kept is not None and kept[0] == every and all(type(own).__module__.startswith("rclpy.") for own in every):
            reused = kept[1]
            assert isinstance(reused, _Waitables)
            return reused
        made = _Waitables.of(every)
        self._executor._waitables = (every, made)
        return made

    def wait(self, end_ns: int | None) -> tuple[list[Ready], bool]:
        """Block until an entity is ready, the executor is woken, or the time is `end_ns`.

        Returns:
            What is ready, in the order in which it is to be called, and whether it is `end_ns`.
        """
        kernel = current_kernel("spin")
        while True:
            ready = self._ready()
            woken = [guard.take_readiness() for guard in self._guards]
            now_ns = kernel.now_us * 1000
            is_over = end_ns is not None and end_ns <= now_ns
            if ready:  # a guard condition that triggers itself is always ready
                kernel.count_work()
            elif is_over:
                kernel.count_look()
            if ready or any(woken) or is_over:
                return ready, is_over
            awaited = [handle for _, _, _, handle in self._plain] + self._waitables.wait_set.entities + self._guards
            # An overdue entity is not ready for another reason: its callback is being executed.
            due = [due_ns for entity in awaited if (due_ns := entity.due_ns()) is not None and due_ns > now_ns]
            block_until_woken(kernel, awaited, min(due if end_ns is None else [*due, end_ns], default=None))

    def _ready(self) -> list[Ready]:
        """The ready entities that may be called now, waitables first."""
        can_execute = self._executor.can_execute
        ready = self._ready_waitables() if self._waitables.wait_set.any_is_ready() else []
        for entity, node, take, handle in self._plain:
            if hasattr(entity, "_executor_triggered"):
                if can_execute(entity) and handle.take_readiness():
                    entity._executor_triggered = True
                is_ready = entity._executor_triggered
            else:
                is_ready = handle.is_ready()
            if is_ready and can_execute(entity):
                ready.append((entity, node, take))
        return ready

    def _ready_waitables(self) -> list[Ready]:
        free = _Waitables.of(list(filter(self._executor.can_execute, self._waitables.waitables)))
        free.wait_set.take()
        ready = [waitable for waitable in free.waitables if waitable.is_ready(free.wait_set)]
        return [(waitable, self._owners[waitable], self._executor._take_waitable) for waitable in ready]


POLL_NS = 1_000_000
"""Period (ns) of polls by `rclpy` without a pause: of tasks of an `EventsExecutor`, and of awaited futures."""


class EventLoop:
    """The part of an `EventsExecutor` that is its own; the rest is that of the base class next to it, `rclpy`'s."""

    _task_class: Any
    _context: Any
    _is_shutdown: bool
    _tasks_lock: Any
    get_nodes: Callable[[], Sequence[Any]]
    wake: Callable[[], None]

    def __init__(self, context: Any) -> None:
        super().__init__(context=context)  # type: ignore[call-arg]
        self._tasks: list[tuple[Any, Any, Any]]
        self._spins = False

    def spin(self) -> None:
        self._run(lambda: False, None)

    def spin_once(self, timeout_sec: float | None = None) -> None:
        self._run(lambda: False, timeout_sec, at_most_one=True)

    def spin_until_future_complete(self, future: Any, timeout_sec: float | None = None) -> None:
        future.add_done_callback(lambda _: self.wake())
        self._run(future.done, timeout_sec)

    def spin_once_until_future_complete(self, future: Any, timeout_sec: float | None = None) -> None:
        future.add_done_callback(lambda _: self.wake())
        self._run(future.done, timeout_sec, at_most_one=True)

    def can_execute(self, entity: Any) -> bool:
        return not entity._executor_event

    def _run(self, is_over: Callable[[], bool], timeout_sec: float | None, *, at_most_one: bool = False) -> None:
        if self._spins:
            raise RuntimeError("Attempt to spin an already-spinning Executor")
        self._spins = True
        kernel = current_kernel("spin")
        lasts = timeout_sec is not None and timeout_sec >= 0
        end_ns = kernel.now_us * 1000 + whole_ns(float(timeout_sec or 0.0)) if lasts else None
        try:
            while self._context.ok() and not self._is_shutdown and not is_over():
                has_run = self._run_next(end_ns)
                if (has_run and at_most_one) or (not has_run and _is_past(end_ns)):
                    return
        finally:
            self._spins = False

    def _run_next(self, end_ns: int | None) -> bool:
        """Run the tasks that continue, or the next callback, or wait for one; whether anything was run."""
        begun = self._tasks_begun()
        if any(self._step(task, entity, node) for task, entity, node in begun):
            return True
        nodes = self.get_nodes()
        if any(True for node in nodes for _ in node.guards):
            raise RuntimeError("Guard conditions not supported")
        entities = Entities(self, nodes)
        looks_ns = current_kernel("spin").now_us * 1000 + POLL_NS if begun else None
        until_ns = min((ns for ns in (end_ns, looks_ns) if ns is not None), default=None)
        ready, _ = entities.wait(until_ns)
        if not ready or self._is_shutdown or not self._context.ok():
            return False
        entity, node, take = min(ready, key=_came)
        self._step(self._make_handler(entity, node, take), entity, node)
        return True

    def _tasks_begun(self) -> list[tuple[Any, Any, Any]]:
        with self._tasks_lock:
            self._tasks = [own for own in self._tasks if not (own[0].done() or own[0].cancelled())]
            return list(self._tasks)

    def _step(self, task: Any, entity: Any, node: Any) -> bool:
        """Go on with a task; whether it is over. Raises what it raised, once it has been logged."""
        task()
        if not task.done():
            return False
        error = task.exception()
        if error is not None:
            _log(self, error, node, entity)
            raise error
        return True

    def _make_handler(self, entity: Any, node: Any, take: Callable[[Any], Any]) -> Any:
        entity._executor_event = True

        async def handle() -> None:
            execute = take(entity)
            entity._executor_event = False
            if execute is not None:
                await execute()

        task = self._task_class(handle, executor=self)
        with self._tasks_lock:
            self._tasks.append((task, entity, node))
        return task


def events_executor(executors: Any) -> type[Any]:
    """The class `EventsExecutor`, below one of the module `rclpy.executors`."""
    return type("EventsExecutor", (EventLoop, executors.SingleThreadedExecutor), {"_task_class": executors.Task})


def _is_past(end_ns: int | None) -> bool:
    return end_ns is not None and end_ns <= current_kernel("spin").now_us * 1000


def _came(ready: Ready) -> tuple[int, int]:
    """When an entity's event came: (ns of simulated time, number of the arrival)."""
    entity = ready[0]
    handle = getattr(entity, "handle", None)
    came = None if handle is None else handle.came()
    return came if came is not None else (current_kernel("spin").now_us * 1000, 0)


_KINDS = ("timers", "subscriptions", "clients", "services", "waitables")


def _log(executor: Any, error: BaseException, node: Any, entity: Any) -> None:
    """Log an error as the extension does: with the logger of the node whose callback raised it."""
    from rclpy.logging import get_logger  # type: ignore[import-not-found, unused-ignore]

    nodes = [node] if node is not None else executor.get_nodes()
    logger = nodes[0].get_logger() if len(nodes) == 1 else get_logger("UNKNOWN")
    kinds: Iterator[str] = (kind for kind in _KINDS if node is not None and entity in getattr(node, kind))
    logger.fatal(f"Exception in '{next(kinds, 'task')}' callback: {error}")
    logger.warning("Error occurred at:\n" + "".join(traceback.format_tb(error.__traceback__)))
