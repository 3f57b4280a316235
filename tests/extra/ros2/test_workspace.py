"""The package of docs/ros2.md in a workspace: its launch file under generated tests, and the commands of colcon."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.docs.page import blocks, run, write_files

_PACKAGE = "arm_control"
_NODE = 'RosNode(entry="arm_control.arm_node:main", parameters=[{"period_s": 0.1}])'

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(find_spec("rclpy") is None, reason="needs rclpy, of a ROS 2 distribution or from pip"),
]


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """A workspace with the package, as the page has it."""
    folder = tmp_path / "src" / _PACKAGE
    folder.mkdir(parents=True)
    run("hricdv init . --robot=cell", folder)
    write_files(blocks("ros2.md"), folder)
    for empty in (f"resource/{_PACKAGE}", f"{_PACKAGE}/__init__.py"):
        (folder / empty).parent.mkdir(exist_ok=True)
        (folder / empty).touch()
    return folder


@pytest.mark.skipif(
    any(find_spec(name) is None for name in ("launch_ros", "launch_xml")), reason="needs launch_ros and launch_xml"
)
def test_the_launch_file_of_the_page_is_tested_without_building(package: Path) -> None:
    conftest = (package / "conftest.py").read_text()
    line = next(block.text for block in blocks("ros2.md") if block.text.startswith("ros = run.ros2(Launch("))
    assert _NODE in conftest
    changed = conftest.replace(f"    ros = run.ros2({_NODE})\n", f"    {line}")
    (package / "conftest.py").write_text(changed.replace("Concretization, Model,", "Concretization, Launch, Model,"))
    status, printed = run("pytest", package)
    assert status == 0, printed
    assert "PASSED  6 passed" in printed


def _commands() -> list[list[str]]:
    """The commands of the page that call colcon, as a shell would."""
    block = next(block.text for block in blocks("ros2.md") if block.text.startswith("python $(which colcon)"))
    colcon = shutil.which("colcon", path=str(Path(sys.executable).parent)) or ""
    return [
        [sys.executable, *shlex.split(line.replace("python $(which colcon)", colcon))] for line in block.splitlines()
    ]


@pytest.mark.skipif(
    any(find_spec(name) is None for name in ("colcon_core", "colcon_ros", "colcon_test_result")),
    reason="needs colcon-core, colcon-ros, colcon-test-result and colcon-python-setup-py",
)
def test_colcon_finds_the_results(package: Path) -> None:
    workspace = package.parents[1]
    for command in _commands():
        done = subprocess.run(command, cwd=workspace, env=dict(os.environ), capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stdout + done.stderr
    suite = next(ElementTree.parse(workspace / "build" / _PACKAGE / "pytest.xml").iter("testsuite"))
    assert {name: suite.get(name) for name in ("tests", "failures", "errors")} == {
        "tests": "6",
        "failures": "0",
        "errors": "0",
    }
    assert f"build/{_PACKAGE}/pytest.xml: 6 tests, 0 errors, 0 failures, 0 skipped" in done.stdout
    assert (workspace / "build" / _PACKAGE / "hri-report" / "index.html").is_file()
