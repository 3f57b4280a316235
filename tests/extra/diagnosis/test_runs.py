"""Runs of experiments and repairs."""

from __future__ import annotations

import pytest

from pytest_hricdv.extra.diagnosis.runs import LEAST_S, MOST_S, most_s


@pytest.mark.parametrize(
    ("usual_s", "limit_s"), [(None, MOST_S), (0.01, LEAST_S), (0.5, 10.0), (1.0, 20.0), (30.0, MOST_S)]
)
def test_a_repair_has_as_much_time_as_many_runs_without_it(usual_s: float | None, limit_s: float) -> None:
    assert most_s(usual_s) == limit_s
