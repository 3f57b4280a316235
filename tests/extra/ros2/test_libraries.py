"""Libraries of a distribution that nodes wait with: `tf2_ros` and `message_filters` see virtual time, too."""

from __future__ import annotations

import json
from importlib.util import find_spec
from pathlib import Path

import pytest

from tests.docs.page import blocks, run, write_files
from tests.extra.ros2.test_examples import CONFTEST

_TF2 = """
import threading

import rclpy
from geometry_msgs.msg import TransformStamped
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.time import Time
from tf2_ros import Buffer, StaticTransformBroadcaster, TransformBroadcaster, TransformException, TransformListener


def moved(parent, child, x):
    transform = TransformStamped(child_frame_id=child)
    transform.header.frame_id, transform.transform.translation.x = parent, x
    return transform


class Arm(Node):
    def __init__(self):
        super().__init__("arm")
        StaticTransformBroadcaster(self).sendTransform(moved("world", "base", 1.0))
        broadcaster = TransformBroadcaster(self)
        self.create_timer(2.5, lambda: broadcaster.sendTransform(moved("base", "hand", 2.0)))


def arm():
    rclpy.init()
    rclpy.spin(Arm())


def watcher():
    rclpy.init()
    node = Node("watcher")
    buffer = Buffer()
    listener = TransformListener(buffer, node, spin_thread=True)
    log = node.get_logger()
    for target, source, timeout_s in (("world", "base", 1.0), ("base", "hand", 1.0), ("base", "hand", 5.0)):
        try:
            found = buffer.lookup_transform(target, source, Time(), timeout=Duration(seconds=timeout_s))
            log.info(f"{source} {found.transform.translation.x}")
        except TransformException:
            log.info(f"no {source}")
    threading.Event().wait()
"""

_FILTERS = """
import rclpy
from message_filters import ApproximateTimeSynchronizer, Subscriber
from rclpy.node import Node
from sensor_msgs.msg import Range


def ranges():
    rclpy.init()
    node = Node("ranges")
    publishers = [node.create_publisher(Range, name, 10) for name in ("left", "right")]

    def publish(publisher):
        message = Range(range=1.0)
        message.header.stamp = node.get_clock().now().to_msg()
        publisher.publish(message)

    node.create_timer(0.5, lambda: publish(publishers[0]))
    node.create_timer(1.02, lambda: publish(publishers[1]))
    rclpy.spin(node)


def both():
    rclpy.init()
    node = Node("both")
    subscribers = [Subscriber(node, Range, name) for name in ("left", "right")]
    together = ApproximateTimeSynchronizer(subscribers, 10, 0.05)
    together.registerCallback(lambda left, right: node.get_logger().info(f"{left.range} {right.range}"))
    rclpy.spin(node)
"""


_GO = "    return Outcome(run.go(limit_s=20.0))\n"
_WRITE = """    ended = run.go(limit_s=20.0)
    logged = [(each.time_s, each.fields["msg"]) for each in run.recorder.messages if each.topic == "rosout"]
    (HERE / "logged.json").write_text(__import__("json").dumps(logged))
    return Outcome(ended)
"""


def _logged(folder: Path, text: str, functions: tuple[str, ...]) -> list[tuple[float, str]]:
    """What nodes logged in 20 s of simulated time, and when (s)."""
    run("hricdv init . --robot=cell", folder)
    write_files([block for block in blocks("ros2.md") if block.name == "pytest.ini"], folder)
    (folder / "robot_nodes.py").write_text(text)
    conftest = CONFTEST.format(packages=("robot_nodes",), declared="", nodes=functions, prefix="robot_nodes:")
    assert _GO in conftest
    (folder / "conftest.py").write_text(conftest.replace(":main", "").replace(_GO, _WRITE))
    (folder / "requirements.toml").write_text(
        '[R1]\ntitle = "no error"\nformula = "always(on(rosout) -> rosout.level < 40)"\n'
    )
    status, printed = run("pytest -x -k one_wish", folder)
    assert status == 0, printed
    return [(time_s, text) for time_s, text in json.loads((folder / "logged.json").read_text())]


def _needs(*modules: str) -> pytest.MarkDecorator:
    return pytest.mark.skipif(any(find_spec(each) is None for each in modules), reason=f"needs {', '.join(modules)}")


@_needs("rclpy", "tf2_ros")
def test_transforms_are_waited_for_in_virtual_time(tmp_path: Path) -> None:
    logged = _logged(tmp_path, _TF2, ("arm", "watcher"))
    assert [text for _, text in logged] == ["base 1.0", "no hand", "hand 2.0"]
    assert [time_s for time_s, _ in logged] == [pytest.approx(each, abs=0.03) for each in (0.0, 1.0, 2.5)]


@_needs("rclpy", "message_filters")
def test_messages_are_brought_together_in_virtual_time(tmp_path: Path) -> None:
    logged = _logged(tmp_path, _FILTERS, ("ranges", "both"))
    assert logged == [(1.02, "1.0 1.0"), (2.04, "1.0 1.0")]  # later ones are more than 0.05 s apart
