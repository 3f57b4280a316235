"""Nodes of ROS 2 have causes as any other code under test: a bug of a node of docs/ros2.md is located and explained."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from tests.docs.page import blocks, run, write_files

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(find_spec("rclpy") is None, reason="needs rclpy, of a ROS 2 distribution"),
]


def causes(folder: Path) -> list[dict[str, Any]]:
    """Of a session with more runs for experiments than a small suite has by default."""
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "--hri-audit=off", "--hri-diagnose=20"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=900)
    assert done.returncode == 1, done.stdout
    assert " fail for 1 cause" in done.stdout
    made: list[dict[str, Any]] = json.loads((folder / "hri-report" / "report.json").read_text(encoding="utf-8"))[
        "causes"
    ]
    return made


def test_a_bug_of_a_node_is_a_cause_in_its_function(tmp_path: Path) -> None:
    run("hricdv init . --robot=cell", tmp_path)
    write_files(blocks("ros2.md"), tmp_path)
    node = tmp_path / "arm_control" / "arm_node.py"
    text = node.read_text(encoding="utf-8")
    assert text.count("moves = not self.is_near") == 1
    node.write_text(text.replace("moves = not self.is_near", "moves = True"), encoding="utf-8")
    (cause,) = causes(tmp_path)
    assert (cause["requirements"], len(cause["tests"])) == (["R2"], 2)
    assert cause["minimal_pair"]["test"] in cause["tests"]
    assert "ArmNode.step" in [place["function"] for place in cause["locations"]]
