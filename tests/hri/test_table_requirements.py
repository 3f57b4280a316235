"""Faults that no requirement of the paper speaks of, each caught by the requirement that does."""

from __future__ import annotations

import pytest

from controller import fetching
from tests.hri import bench


def test_a_leg_that_is_swung_along_the_table_fails_r29(monkeypatch: pytest.MonkeyPatch) -> None:
    brings = fetching.TO_HANDOVER[1:]
    assert bench.run(bench.concrete(bench.leg())).verdict("R29").verdict == "Passed"
    monkeypatch.setattr(fetching, "TO_HANDOVER", brings)
    verdict = bench.run(bench.concrete(bench.leg())).verdict("R29")
    (violation,) = verdict.violations
    assert (verdict.verdict, verdict.attempts) == ("Failed", 1)
    assert violation.values["leg_height"] < 0.65
    assert violation.values["leg_offset"] == pytest.approx(0.45, abs=0.02)
