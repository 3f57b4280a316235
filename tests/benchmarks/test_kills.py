"""A few of the kills that `python -m benchmarks.kills` makes: nothing is lost."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.kills.__main__ import Run
from benchmarks.kills.parts import KINDS


@pytest.mark.slow
def test_no_kill_and_no_signal_loses_a_result(tmp_path: Path) -> None:
    tally = Run(tmp_path, seed=1).run(kills=15, signals=1, full=1)
    assert not tally.faults
    assert tally.counts["finished results"] > 34


@pytest.mark.slow
def test_no_signal_loses_what_a_part_has_reached(tmp_path: Path) -> None:
    tally = Run(tmp_path / "tests", seed=1).run_parts(tmp_path / "parts", signals=1)
    assert not tally.faults
    assert sum(tally.killed[f"signals while {kind}"] for kind in KINDS) >= 3  # of short ones, some are over before
