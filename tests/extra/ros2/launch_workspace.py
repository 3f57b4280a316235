"""A package of nodes with launch files, as `ros2 pkg create` makes one, and runs of it without a session."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pytest_hricdv.declarations.ros2 import Launch, Ros2, RosNode
from pytest_hricdv.extra.ros2 import system
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import MonitorSet
from pytest_hricdv.run import Run
from pytest_hricdv.runtime import Bus, Kernel, Recorder

_MANIFEST = "<package format='3'><name>{name}</name><version>0.0.0</version></package>"
_SETUP = """
from setuptools import find_packages, setup

package_name = "cell"
setup(
    name=package_name,
    packages=find_packages(exclude=["test"]),
    entry_points={"console_scripts": [
        "talker = cell.nodes:talker", "once = " + package_name + ".nodes:once", f"fails = {package_name}.nodes:fails",
        "managed = cell.nodes:managed",
    ]},
)
"""
_NODES = """
import os
import sys
import time

import rclpy
from rclpy.executors import ExternalShutdownException
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.node import Node
from std_msgs.msg import String


class Talker(Node):
    def __init__(self):
        super().__init__("talker")
        text = self.declare_parameter("text", "hello").value
        publisher = self.create_publisher(String, "chatter", 10)
        said = f"{self.get_fully_qualified_name()} {text} {os.environ.get('WHO', '-')}"
        self.create_timer(self.declare_parameter("period", 1.0).value, lambda: publisher.publish(String(data=said)))


def talker():
    rclpy.init()
    node = Talker()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException) as error:
        node.get_logger().info(f"ended by {type(error).__name__}")


def once():
    rclpy.init()
    Node("once").get_logger().info("once " + " ".join(sys.argv[1:3]))
    time.sleep(2.0)


def fails():
    rclpy.init()
    Node("fails").get_logger().info("up")
    time.sleep(0.5)
    sys.exit(3)


class Managed(LifecycleNode):
    def on_configure(self, state):
        self.get_logger().info("configured")
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state):
        self.get_logger().info("active")
        return super().on_activate(state)


def managed():
    rclpy.init()
    rclpy.spin(Managed("managed"))
"""


def write_package(folder: Path, **launch_files: str) -> Path:
    """Write the sources of a package `cell` into a workspace; returns the folder of the package.

    Args:
        launch_files: by name, with "__" for the dot.
    """
    package = folder / "src" / "cell"
    for path, text in {
        "package.xml": _MANIFEST.format(name="cell"),
        "setup.py": _SETUP,
        "cell/__init__.py": "",
        "cell/nodes.py": _NODES,
        "config/cell.yaml": "/**:\n  ros__parameters:\n    text: from a file\n",
        **{f"launch/{name.replace('__', '.')}": text for name, text in launch_files.items()},
    }.items():
        (package / path).parent.mkdir(parents=True, exist_ok=True)
        (package / path).write_text(text)
    return package


def write_manifest(folder: Path, name: str) -> Path:
    """Write the package.xml of a package of no particular kind; returns its folder."""
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text(_MANIFEST.format(name=name))
    return folder


def ran(*nodes: Launch | RosNode, limit_s: float = 10.0) -> tuple[list[tuple[float, str, Any]], Run]:
    """Run launch files and nodes, without a world: when, topic, and what was said there of all messages."""
    kernel, recorder = Kernel(), Recorder()
    test = ConcreteTest(id="t", suite="by-hand", seed=0, actions=())
    run = Run(test, kernel, Bus(kernel, (), recorder), recorder, lambda body: body, MonitorSet(()))
    middleware = run.middleware = system.Ros2Overlay(Ros2(), ("cell",))
    kernel.virtual = middleware.virtual
    with middleware.modules.install():
        run.ros2(*nodes)
        run.go(limit_s)
    messages = [(message.time_s, message.topic, dict(message.fields)) for message in recorder.messages]
    return [(time_s, topic, fields.get("data", fields.get("msg", fields))) for time_s, topic, fields in messages], run
