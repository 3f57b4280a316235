"""A few of the kills that `python -m benchmarks.kills` makes: nothing is lost."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.kills.__main__ import Run
from benchmarks.kills.parts import KINDS
from studies.session import ROOT


@pytest.mark.slow
def test_no_kill_and_no_signal_loses_a_result(tmp_path: Path) -> None:
    tally = Run(tmp_path, seed=1).run(kills=1, signals=1, full=1)
    assert not tally.faults
    assert tally.counts["finished results"] > 14


@pytest.mark.slow
def test_no_signal_loses_what_a_part_has_reached() -> None:
    """In a process of its own: sessions are forks of it, and a session within pytest would be another one."""
    options = ("--kills=0", "--signals=0", "--full=0", "--parts=1", "--seed=1")
    run = subprocess.run(
        [sys.executable, "-m", "benchmarks.kills", *options], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stdout + run.stderr
    hit = re.findall(r"^signals while (\w+) +1$", run.stdout, re.MULTILINE)
    assert set(hit) <= set(KINDS)
    assert len(hit) >= 3  # of short ones, some are over before
