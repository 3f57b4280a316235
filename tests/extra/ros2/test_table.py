"""The table assembly with nodes of ROS 2 instead of the controller: the same suite, and the same verdicts."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[3]
TABLE = Path(__file__).parent / "table"

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(find_spec("rclpy") is None, reason="needs rclpy, of a ROS 2 distribution"),
]


def _verdicts(report: Path, *arguments: str) -> dict[str, Any]:
    """Test -> the verdicts of its requirements, of some tests of the learned suite."""
    selected = ["-k", "leg1-0 or leg2-0 or leg3-1", "--hri-suite=rl", f"--hri-report={report}"]
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-W", "ignore", *selected, *arguments]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    tests = json.loads((report / "report.json").read_text())["tests"]
    return {test["id"]: {name: each["verdict"] for name, each in test["requirements"].items()} for test in tests}


def test_the_nodes_get_the_verdicts_of_the_controller(tmp_path: Path) -> None:
    plain = _verdicts(tmp_path / "plain", "tests/hri/test_table_assembly.py")
    nodes = _verdicts(tmp_path / "nodes", "-c", str(TABLE / "pytest.ini"), "--rootdir", str(TABLE), str(TABLE))
    assert len(plain) > 5
    assert nodes == plain
