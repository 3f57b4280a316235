"""Time-outs of the real `rclpy`, each shorter than its clocks can tell or ending by a rounded difference."""

from __future__ import annotations

from importlib.util import find_spec

import pytest

from pytest_hricdv.runtime import Kernel
from pytest_hricdv.runtime.virtual.outside import guard_run

pytestmark = [
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),  # of rclpy itself
    pytest.mark.skipif(find_spec("rclpy") is None, reason="needs rclpy"),
]

_LIMIT_S = 100.0

_BODIES: dict[str, tuple[str, float]] = {
    "a future that never is done": (
        "for _ in range(5): rclpy.spin_until_future_complete(node, Future(), timeout_sec=0.1)",
        0.5,
    ),
    "several threads": (
        "executor = MultiThreadedExecutor(); executor.add_node(node)\n"
        "for _ in range(5): executor.spin_until_future_complete(Future(), timeout_sec=0.1)",
        0.5,
    ),
    "a coroutine that waits": (
        "executor = SingleThreadedExecutor(); executor.add_node(node); never = Future()\n"
        "async def wait(): await never\n"
        "executor.create_task(wait)\n"
        "for _ in range(5): executor.spin_until_future_complete(Future(), timeout_sec=0.1)",
        0.5,
    ),
    "a spin of less than a nanosecond": (
        "while time.monotonic() < 0.001: rclpy.spin_once(node, timeout_sec=1e-12)",
        0.001,
    ),
    "a timer with such a period": (
        "node.create_timer(1e-12, lambda: None)\nwhile time.monotonic() < 0.001: rclpy.spin_once(node)",
        0.001,
    ),
    "a timer with no period": (
        "node.create_timer(0.0, lambda: None)\nwhile time.monotonic() < 0.001: rclpy.spin_once(node)",
        0.001,
    ),
    "a rate": (
        "rate = node.create_rate(1e10)\n"
        "threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()\n"
        "while time.monotonic() < 0.001: rate.sleep()",
        0.001,
    ),
    "clocks": (
        "for kind in (ClockType.STEADY_TIME, ClockType.SYSTEM_TIME, ClockType.ROS_TIME):\n"
        "    clock = Clock(clock_type=kind); end = clock.now() + Duration(seconds=0.001)\n"
        "    while clock.now() < end: clock.sleep_for(Duration(seconds=1e-12))",
        0.003,
    ),
    "a message": ("while time.monotonic() < 0.001: wait_for_message(Bool, node, 't', time_to_wait=1e-13)", 0.001),
    "a service": ("assert not node.create_client(Trigger, 's').wait_for_service(timeout_sec=1e-12)", 0.25),
    "the executor's end": ("SingleThreadedExecutor().shutdown(timeout_sec=1e-12)", 0.0),
}

_HEAD = """
import threading, time
import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future
from rclpy.wait_for_message import wait_for_message
from std_msgs.msg import Bool
from std_srvs.srv import Trigger
"""


@pytest.mark.parametrize("name", _BODIES)
def test_a_time_out_ends(name: str, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> None:
    from pytest_hricdv.extra.ros2.overlay import virtual_rclpy

    code, least_s = _BODIES[name]
    module = f"waits_{list(_BODIES).index(name)}"
    folder = tmp_path_factory.mktemp("code")
    lines = "".join(f"    {line}\n" for line in code.splitlines())
    (folder / f"{module}.py").write_text(
        f"{_HEAD}\ndef main():\n    rclpy.init(); node = Node('waits')\n{lines}    rclpy.try_shutdown()\n"
    )
    monkeypatch.syspath_prepend(folder)
    kernel = Kernel()
    kernel.virtual = frozenset({"time", "threading"})
    with virtual_rclpy(module):
        kernel.spawn(name, __import__(module).main)
        try:
            with guard_run(kernel):
                assert kernel.run(_LIMIT_S) == "idle"
        finally:
            kernel.close()
    assert least_s <= kernel.now_s <= least_s + 0.001
