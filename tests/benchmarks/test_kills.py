"""A few of the kills that `python -m benchmarks.kills` makes: nothing is lost."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.kills.__main__ import Run


@pytest.mark.slow
def test_no_kill_and_no_signal_loses_a_result(tmp_path: Path) -> None:
    tally = Run(tmp_path, seed=1).run(kills=15, signals=1, full=1)
    assert not tally.faults
    assert tally.counts["finished results"] > 34
