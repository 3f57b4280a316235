"""Time: timers, rates, clocks, simulated time that somebody publishes."""

from __future__ import annotations

import threading
import time
from itertools import pairwise
from typing import Any

import rclpy
from rclpy.clock import Clock, ClockType, JumpThreshold
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.time import Time
from rclpy.timer import TimerInfo
from rosgraph_msgs.msg import Clock as ClockMessage

from tests.extra.ros2.differential.common import Log, alone, elapse, raised, together, until


def ticking(log: Log) -> None:
    """Two timers of one node, the second of which ends the first."""
    rclpy.init()
    node, ticks = Node("ticking"), []
    fast = node.create_timer(0.2, lambda: ticks.append("fast"))

    def end_fast() -> None:
        ticks.append("slow")
        fast.cancel()

    slow = node.create_timer(0.5, end_fast)
    until(node, lambda: ticks.count("slow") == 2)
    log("ticks", ticks)
    log("canceled", [fast.is_canceled(), slow.is_canceled()])


def resetting(log: Log) -> None:
    """Timers that are cancelled, reset, made slower, destroyed, not started, or not periodic."""
    rclpy.init()
    node, ticks = Node("node"), []
    timer = node.create_timer(0.2, lambda: ticks.append("periodic"))
    idle = node.create_timer(0.01, lambda: ticks.append("idle"), autostart=False)
    log("idle", [idle.is_canceled(), idle.is_ready()])
    until(node, lambda: len(ticks) == 2)
    log("next", [0.0 < timer.time_until_next_call() / 1e9 <= 0.2, 0.0 <= timer.time_since_last_call() / 1e9 < 0.2])
    timer.cancel()
    log("canceled", [timer.is_canceled(), timer.time_until_next_call()])
    elapse(node, 0.3)
    log("ticks", list(ticks))
    timer.reset()
    log("reset", timer.is_canceled())
    until(node, lambda: len(ticks) == 3)
    timer.timer_period_ns = 50_000_000
    log("period", timer.timer_period_ns)
    until(node, lambda: len(ticks) == 6)
    log("destroyed", node.destroy_timer(timer))
    log("after the end", raised(timer.reset))
    elapse(node, 0.1)
    log("ticks", len(ticks))

    def once() -> None:
        ticks.append("once")
        single.cancel()

    single = node.create_timer(0.05, once)
    elapse(node, 0.3)
    log("once", ticks.count("once"))
    log("negative", raised(lambda: node.create_timer(-1.0, once)))
    log("zero", raised(lambda: node.create_timer(0.0, once).cancel()))


def informed(log: Log) -> None:
    """Callbacks that take when they were expected, and when they came."""
    rclpy.init()
    node, calls = Node("node"), []

    def note(info: TimerInfo) -> None:
        calls.append(info)

    note.__annotations__["info"] = TimerInfo  # rclpy looks at it, and wants no text
    timer = node.create_timer(0.1, note)
    until(node, lambda: len(calls) == 3)
    timer.cancel()
    for info in calls:
        log("late", 0 <= (info.actual_call_time - info.expected_call_time).nanoseconds < 100_000_000)
    expected = [info.expected_call_time.nanoseconds for info in calls]
    log("period", [later - earlier for earlier, later in pairwise(expected)])


def rating(log: Log) -> None:
    """Rates, in a thread beside the one that spins; destroyed while something sleeps in it."""
    rclpy.init()
    node = Node("node")
    spun = together(node)
    thread = threading.Thread(target=spun.spin)
    thread.start()
    rate, start_s = node.create_rate(10.0), time.monotonic()
    for _ in range(4):
        rate.sleep()
    log("four at 10 Hz", 0.3 <= time.monotonic() - start_s < 0.75)
    log("destroyed", node.destroy_rate(rate))
    slow, outcome = node.create_rate(0.1), []
    sleeper = threading.Thread(target=lambda: outcome.append(raised(slow.sleep)))
    sleeper.start()
    time.sleep(0.1)
    slow.destroy()
    sleeper.join()
    log("woken", outcome)
    log("wrong", raised(lambda: node.create_rate(0.0)))
    spun.shutdown()
    thread.join()


def simulated(log: Log) -> None:
    """Nodes that use simulated time: somebody publishes it, forwards, backwards, and timers follow."""
    rclpy.init()
    node = Node("node", parameter_overrides=[Parameter("use_sim_time", value=True)])
    talker = Node("talker")
    ticks: list[Any] = []
    jumps: list[Any] = []
    publisher = talker.create_publisher(ClockMessage, "/clock", 10)
    spun = together(node, talker)
    until(spun, lambda: publisher.get_subscription_count() == 1)
    clock = node.get_clock()
    kept = clock.create_jump_callback(
        JumpThreshold(min_forward=Duration(seconds=5), min_backward=Duration(seconds=-1), on_clock_change=True),
        post_callback=lambda jump: jumps.append([jump.clock_change.name, jump.delta.nanoseconds]),
    )

    def be(second: float) -> None:
        publisher.publish(ClockMessage(clock=Time(seconds=second).to_msg()))
        until(spun, lambda: clock.now().nanoseconds == round(second * 1e9))
        elapse(spun, 0.02)
        log("ticks", [second, len(ticks)])

    log("active", clock.ros_time_is_active)
    be(100.0)
    node.create_timer(1.0, lambda: ticks.append(clock.now().nanoseconds))
    for second in (100.5, 101.0, 101.5, 103.25, 104.0, 110.0, 110.5, 50.0, 51.0):
        be(second)
    log("at", ticks)
    log("steady", node.create_timer(0.05, lambda: None, clock=Clock(clock_type=ClockType.STEADY_TIME)).is_ready())
    node.set_parameters([Parameter("use_sim_time", value=False)])
    log("inactive", [clock.ros_time_is_active, clock.now().nanoseconds > 10**17])
    log("jumps", jumps)
    kept.unregister()


def sleeping_in_simulated_time(log: Log) -> None:
    """A thread that sleeps until a time that somebody publishes."""
    rclpy.init()
    node = Node("node", parameter_overrides=[Parameter("use_sim_time", value=True)])
    talker, slept = Node("talker"), []
    publisher = talker.create_publisher(ClockMessage, "/clock", 10)
    spun = together(node, talker)
    until(spun, lambda: publisher.get_subscription_count() == 1)
    clock = node.get_clock()

    def be(second: int) -> Any:
        publisher.publish(ClockMessage(clock=Time(seconds=second).to_msg()))
        return until(spun, lambda: clock.now().nanoseconds == second * 10**9)

    be(10)
    thread = threading.Thread(
        target=lambda: slept.append(clock.sleep_until(Time(seconds=12, clock_type=ClockType.ROS_TIME)))
    )
    thread.start()
    be(11)
    elapse(spun, 0.1)
    log("at 11", slept)
    be(12)
    thread.join()
    log("at 12", slept)


SYSTEMS = {
    "timers": alone(ticking),
    "timers that are changed": alone(resetting),
    "calls of timers": alone(informed),
    "rates": alone(rating),
    "simulated time": alone(simulated),
    "sleep in simulated time": alone(sleeping_in_simulated_time),
}
