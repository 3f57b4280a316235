"""A session is read on a screen: 15 lines where it passes, 35 where it fails, and six for each further cause."""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from tests.docs.page import blocks, commands, run, write_files

ROOT = Path(__file__).parents[2]
GREEN_LINES, RED_LINES, CAUSE_LINES, MAX_CAUSES = 15, 35, 6, 5
_DOTS = re.compile(r"^(\S+\.py )?[.xXFEs]+ *(\[ *\d+%\])?$")
"""Of pytest, a character for each test."""
_WAIT = re.compile(r"^hricdv: generating ")
"""Said after two seconds only."""
NEEDS_RCLPY = pytest.mark.skipif(find_spec("rclpy") is None, reason="needs rclpy")


def counted_lines(folder: Path, report: Path, command: str) -> tuple[list[str], dict[str, object]]:
    """The lines of a session without its dots and what a slow machine says of waits, and its report."""
    dropped = ("PYTEST_ADDOPTS", "CI", "BUILD_NUMBER", "GITHUB_ACTIONS", "GITHUB_STEP_SUMMARY", "FORCE_COLOR")
    environment = {name: value for name, value in os.environ.items() if name not in dropped} | {"COLUMNS": "80"}
    words = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", f"--hri-report={report}", *shlex.split(command)]
    ran = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert ran.returncode in (0, 1), ran.stdout + ran.stderr
    lines = [line for line in ran.stdout.splitlines() if not _DOTS.match(line) and not _WAIT.match(line)]
    return lines, json.loads((report / "report.json").read_text(encoding="utf-8"))


def project_of(page: str, folder: Path) -> Path:
    """What a page makes before its first session."""
    for block in blocks(page):
        if block.text.startswith("$ pytest"):
            break
        for command, _ in commands(block.text) if block.kind == "console" else ():
            assert run(command, folder)[0] == 0
        write_files([block], folder)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize(
    ("where", "command", "is_red"),
    [
        pytest.param("tutorial.md", "--hri-tests=8", True, id="tutorial"),
        pytest.param("vacuum.md", "--hri-suite=closure", False, id="closure"),
        pytest.param("ros2.md", "", False, id="ROS 2", marks=NEEDS_RCLPY),
        pytest.param(ROOT, "--hri-suite=rl --hri-tests=8 -n 2", False, id="table"),
        pytest.param(ROOT, "--hri-suite=by-hand --hri-strict -k leg3-bored --hri-diagnose=4", True, id="by hand"),
        pytest.param(ROOT / "examples" / "home_care", "--hri-suite=rl --hri-tests=6", False, id="home care"),
    ],
)
def test_a_session_is_read_on_a_screen(where: str | Path, command: str, is_red: bool, tmp_path: Path) -> None:
    folder = project_of(where, tmp_path) if isinstance(where, str) else where
    with TemporaryDirectory() as short:  # pytest's are so long that the verdict has no room beside it
        lines, report = counted_lines(folder, Path(short), command)
    causes = report.get("causes", ())
    assert isinstance(causes, list | tuple)
    most = RED_LINES + CAUSE_LINES * (min(max(len(causes), 1), MAX_CAUSES) - 1) if is_red else GREEN_LINES
    assert len(lines) <= most, "\n".join(lines)
    assert any(line.startswith("FAILED  " if is_red else ("PASSED  ", "NO TEST PASSED  ")) for line in lines[-2:])
    assert all(len(line) <= 80 for line in lines if not line.startswith(("  again", "hricdv: ", "FAILED R")))
