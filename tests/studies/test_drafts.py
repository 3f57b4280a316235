"""The study of drafts: what is counted as found, what is noted of it, and which code is fetched."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from studies.code_bases import CodeBase, ros2
from studies.drafts import found

NODE = """\
import rclpy
from rclpy.node import Node
from std_msgs.msg import Bool, Empty


class Door(Node):
    def __init__(self):
        super().__init__("door")
        self.open = self.create_publisher(Bool, "open", 10)
        self.create_subscription(Empty, "knock", lambda _: self.open.publish(Bool(data=True)), 10)


def main():
    rclpy.init()
    rclpy.spin(Door())
"""


def door(folder: Path, *messages: str) -> CodeBase:
    (folder / "door.py").write_text(NODE, encoding="utf-8")
    nothing: frozenset[str] = frozenset()
    names = {"messages": frozenset(messages), "states": nothing, "transitions": nothing, "values": nothing}
    return CodeBase("door", "a door", folder, ("--ros2", "door.py"), names)


def repository(folder: Path) -> str:
    """A repository with two commits; the first one."""
    git = ["git", "-C", str(folder), "-c", "user.name=a", "-c", "user.email=a@b.c"]
    subprocess.run(["git", "init", "--quiet", str(folder)], check=True)
    for text in ("first", "second"):
        (folder / "file.txt").write_text(text, encoding="utf-8")
        subprocess.run([*git, "add", "."], check=True)
        subprocess.run([*git, "commit", "--quiet", "-m", text], check=True)
    return subprocess.run([*git, "rev-parse", "HEAD~1"], check=True, capture_output=True, text=True).stdout.strip()


def test_the_side_that_a_node_has_of_a_topic_counts(tmp_path: Path) -> None:
    code = door(tmp_path, "publisher /open std_msgs/msg/Bool", "publisher /knock std_msgs/msg/Empty")
    assert found(code)["messages"] == "2, 1, 2"


def test_a_repository_is_cloned_at_its_commit_and_another_commit_is_said(tmp_path: Path) -> None:
    source, target = tmp_path / "source", tmp_path / "target"
    commit = repository(source)
    ros2.fetch(target, str(source), commit)
    assert (target / "file.txt").read_text(encoding="utf-8") == "first"
    ros2.fetch(target, "nowhere", commit)  # is there: nothing is cloned
    with pytest.raises(ros2.FetchError, match=f"expected commit {commit}"):
        ros2.fetch(source, "nowhere", commit)


def test_a_repository_that_cannot_be_cloned_is_said(tmp_path: Path) -> None:
    with pytest.raises(ros2.FetchError, match="git clone"):
        ros2.fetch(tmp_path / "target", str(tmp_path / "nowhere"), "0" * 40)
