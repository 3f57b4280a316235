"""Timers, guard conditions and wait sets in virtual time."""

from __future__ import annotations

from typing import Any

import pytest

from pytest_hricdv.extra.ros2.clocks import (
    Clock,
    ClockType,
    RosTimer,
    TimePoint,
    need_no_clock_topic,
)
from pytest_hricdv.extra.ros2.executor import _in_order
from pytest_hricdv.extra.ros2.wait_set import GuardCondition
from pytest_hricdv.runtime import Kernel, KernelError
from tests.extra.ros2.system import node, run, wait

_MS = 1_000_000


@pytest.mark.parametrize(("period_ns", "calls", "least_us"), [(300, 1000, 300), (0, 100, 99)])
def test_a_period_of_less_than_the_kernels_resolution_lets_time_pass(period_ns: int, calls: int, least_us: int) -> None:
    """A timer without a period is due as often as the machine can call it; here as often as time passes."""

    def robot(kernel: Kernel) -> None:
        timer = RosTimer(Clock(ClockType.STEADY_TIME), node("robot").context, period_ns)
        for _ in range(calls):
            wait("timer", [timer])
            timer.call_timer()

    kernel, why = run(robot)
    assert why == "idle"
    assert least_us <= kernel.now_us <= least_us + 800


def test_a_timer_of_an_overridden_clock_waits_until_the_clock_is_set() -> None:
    seen: list[Any] = []

    def robot(kernel: Kernel) -> None:
        clock = Clock(ClockType.ROS_TIME)
        clock.set_ros_time_override(TimePoint(0, ClockType.ROS_TIME))
        clock.set_ros_time_override_is_enabled(True)
        timer = RosTimer(clock, node("robot").context, 1000 * _MS)

        def simulator() -> None:
            for second in (1, 2):
                kernel.sleep(5.0)
                clock.set_ros_time_override(TimePoint(second * 600 * _MS, ClockType.ROS_TIME))

        kernel.spawn("simulator", simulator)
        wait("timer", [timer])
        seen.append(kernel.now_s)

    run(robot)
    assert seen == [10.0]


@pytest.mark.parametrize(
    ("needs_clock", "expected"), [(False, [([0], 0.01), ([0], 1.5)]), (True, [([], 1.0), ([0], 1.5)])]
)
def test_until_it_is_set_an_overridden_clock_reads_the_kernel_if_it_may(
    needs_clock: bool, expected: list[tuple[list[int], float]]
) -> None:
    """As `use_sim_time` of `rclpy` does: it sets 0 until somebody publishes `/clock`."""
    seen: list[Any] = []

    def robot(kernel: Kernel) -> None:
        if not needs_clock:
            need_no_clock_topic(kernel)
        clock = Clock(ClockType.ROS_TIME)
        clock.set_ros_time_override(TimePoint(0, ClockType.ROS_TIME))
        clock.set_ros_time_override_is_enabled(True)
        timer = RosTimer(clock, node("robot").context, 10 * _MS)
        seen.append((wait("timer", [timer], timeout_s=1.0), kernel.now_s))
        kernel.sleep(1.5 - kernel.now_s)
        clock.set_ros_time_override(TimePoint(2**62, ClockType.ROS_TIME))
        seen.append((wait("timer", [timer], timeout_s=1.0), kernel.now_s))

    run(robot)
    assert seen == expected


def test_a_loop_that_polls_without_end_is_an_error() -> None:
    def robot(kernel: Kernel) -> None:
        guard = GuardCondition(node("robot").context)
        while True:
            wait("guard_condition", [guard], timeout_s=0.0)

    with pytest.raises(KernelError, match=r"polls without time passing, at \S+: a loop must sleep"):
        run(robot)


def test_callbacks_that_are_ready_are_called_as_the_schedule_has_it() -> None:
    called: list[list[Any]] = []

    def robot(kernel: Kernel) -> None:
        for picks in (lambda count: 0, lambda count: count - 1):
            kernel.pick = picks
            called.append([entity for entity, _, _ in _in_order([(name, None, None) for name in "abc"])])

    run(robot)
    assert called == [["a", "b", "c"], ["c", "b", "a"]]
