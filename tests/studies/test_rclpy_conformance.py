"""`python -m studies.rclpy_conformance`, with a small library in the place of `rclpy`."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

_LIBRARY = """
import threading, time
from rclpy import _rclpy_pybind11 as extension

context = lambda: extension.Context([], extension.RCL_DEFAULT_DOMAIN_ID)
"""

_TESTS = """
import threading, time

import pytest

from pytest_hricdv._base.message import InputError
from studies import rclpy_conformance
import rclpy


def test_a_month_passes_at_once():
    clock = rclpy.extension.Clock(rclpy.extension.ClockType.STEADY_TIME)
    timer = rclpy.extension.Timer(clock, rclpy.context(), 30 * 86400 * 10**9, True)
    threading.Thread(target=time.sleep, args=(1.0,)).start()
    waiting = rclpy.extension.WaitSet(0, 0, 1, 0, 0, 0, None)
    waiting.add_timer(timer)
    waiting.wait(-1)
    assert waiting.get_ready_entities("timer") == [timer.pointer]


def test_waits_for_ever():
    threading.Event().wait()


def test_fails():
    assert rclpy.extension.rclpy_remove_ros_args(["a", "--ros-args", "b"]) == ["a", "b"], "the arguments differ"


@pytest.mark.skip(reason="not here")
def test_is_skipped():
    pass
"""


def _conformance(tmp_path: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "studies.rclpy_conformance", *arguments]
    root = str(Path(__file__).parents[2])
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(tmp_path / "library"), root])}
    return subprocess.run(command, capture_output=True, text=True, env=environment, cwd=tmp_path, check=False)


@pytest.fixture
def source(tmp_path: Path) -> Path:
    for name, text in (("library/rclpy/__init__.py", _LIBRARY), ("source/rclpy/test/test_clock.py", _TESTS)):
        path = tmp_path / name
        path.parent.mkdir(parents=True)
        path.write_text(text)
    (tmp_path / "source/rclpy/test/__init__.py").write_text("import test_rclpy")
    return tmp_path / "source"


@pytest.mark.slow
def test_each_test_is_run_also_after_one_that_stops_the_run(tmp_path: Path, source: Path) -> None:
    done = _conformance(tmp_path, str(source))
    assert done.returncode == 1, done.stderr
    lines = done.stdout.splitlines()
    assert ["test_clock.py", "1", "2", "1"] in [line.split() for line in lines]
    assert "stopped the run: test_clock.py::test_waits_for_ever" in lines
    assert lines[lines.index("failed: test_clock.py::test_fails") + 1].startswith("    AssertionError: the arguments")
    assert lines[lines.index("skipped: test_clock.py::test_is_skipped") + 1] == "    Skipped: not here"


def test_what_is_missing_is_said(tmp_path: Path, source: Path) -> None:
    done = _conformance(tmp_path, str(tmp_path))
    assert (done.returncode, done.stdout) == (2, "")
    assert "no tests of rclpy; expected a checkout of ros2/rclpy" in done.stderr
    done = _conformance(tmp_path, str(source), "-k", "lidar")
    assert done.stderr == "ERROR: no file of tests has 'lidar' in its name\n"
