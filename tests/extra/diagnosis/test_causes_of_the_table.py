"""On MuJoCo, too, the table's known fault is a cause at its place: a hand that closes without looking who is there."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(find_spec("mujoco") is None, reason="needs mujoco"),
]


def test_on_mujoco_the_table_s_known_fault_is_where_the_hand_closes(tmp_path: Path) -> None:
    options = ["--hri-suite=rl", "--hri-strict", "--hri-engine=mujoco", "--hri-audit=off", f"--hri-report={tmp_path}"]
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-k", "leg4", *options]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=900)
    assert done.returncode == 1, done.stdout
    report = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    (cause,) = report["causes"]
    assert (cause["requirements"], cause["state"]) == (["R3"], "Move_hand")
    assert [place["function"] for place in cause["locations"][:2]] == ["grasp", "grasp"]
    assert report["diagnosis"]["runs"] <= 48
    assert "--hri-engine=mujoco" in done.stdout.partition("FAILURES")[0]
