"""How many times as fast as real time two nodes of ROS 2 run: `python -m benchmarks.ros2_nodes`.

A talker and a listener. It needs `rclpy` and `std_msgs`, of a ROS 2 distribution that is sourced. Each figure is the
median of several tries, by the processor time that they took, so that other work of the machine has no effect.
"""

from __future__ import annotations

import statistics
import sys
import time
from typing import Any

from pytest_hricdv.extra.ros2.overlay import virtual_rclpy
from pytest_hricdv.extra.ros2.processes import ModuleVariables, Process
from pytest_hricdv.runtime import Kernel
from pytest_hricdv.runtime.virtual.outside import guard_run

TRIES = 5  # an odd number, so that the median is one of them
RATES = {10.0: 60.0, 100.0: 30.0}
"""Messages a second -> simulated time of a try (s)."""


def talk(rate_hz: float) -> None:
    """A node that publishes, as its author would write it."""
    import rclpy  # type: ignore[import-not-found, unused-ignore]
    from rclpy.node import Node  # type: ignore[import-not-found, unused-ignore]
    from std_msgs.msg import String  # type: ignore[import-not-found, unused-ignore]

    rclpy.init()
    node = Node("talker")
    publisher = node.create_publisher(String, "chatter", 10)
    node.create_timer(1 / rate_hz, lambda: publisher.publish(String(data="hello")))
    rclpy.spin(node)


def listen(heard: list[Any]) -> None:
    """A node that subscribes."""
    import rclpy
    from rclpy.node import Node
    from std_msgs.msg import String

    rclpy.init()
    node = Node("listener")
    node.create_subscription(String, "chatter", heard.append, 10)
    rclpy.spin(node)


def times_real(rate_hz: float, simulated_s: float) -> float:
    """Simulated time for one second of processor time, after a first second in which the nodes find each other."""
    kernel = Kernel()
    kernel.virtual = frozenset({"time", "threading"})
    heard: list[Any] = []
    with virtual_rclpy():
        import rclpy.executors  # type: ignore[import-not-found, unused-ignore]  # noqa: F401 (before it is adapted)

        variables = ModuleVariables(["rclpy"])
        variables.update()
        for name, body in (("talker", lambda: talk(rate_hz)), ("listener", lambda: listen(heard))):
            kernel.spawn(name, Process(kernel, variables, [name]).wrap(body))
        with guard_run(kernel):
            kernel.run(1.0)
            begun = time.process_time()
            kernel.run(1.0 + simulated_s)
            took_s = time.process_time() - begun
        kernel.close()
    assert len(heard) >= rate_hz * simulated_s, "messages were lost"
    return simulated_s / took_s


def main() -> None:
    """Measure, and print a line for each rate."""
    print(f"Python {sys.version.partition(' ')[0]}, two nodes, median of {TRIES} tries")
    for rate_hz, simulated_s in RATES.items():
        factors = sorted(times_real(rate_hz, simulated_s) for _ in range(TRIES))
        span = f"{factors[0]:.0f} to {factors[-1]:.0f}"
        print(f"{rate_hz:5.0f} Hz: {statistics.median(factors):.0f} times as fast as real time ({span})")


if __name__ == "__main__":
    main()
