"""The spellings of docs/requirements.md for STL's meaning, against rtamt's evaluation of the STL formula itself."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from pytest_hricdv.monitor import Vocabulary, parse_formula
from tests.monitor.logged_run import TICK_S, Instant, LoggedRun
from tests.monitor.logs import run

pytest.importorskip("rtamt", reason="the oracle has no release for this Python")

from tests.monitor import rtamt_oracle

VOCABULARY = Vocabulary(signals={"a": float, "b": float})

SPELLINGS = {
    "eventually": "always(once[{end}:{end}](a > 0) -> once[0:{width}](b > 0))",
    "always": "always(once[{end}:{end}](a > 0) -> historically[0:{width}](b > 0))",
}

values = st.lists(st.tuples(st.booleans(), st.booleans()), min_size=2, max_size=40)


@settings(suppress_health_check=list(HealthCheck), deadline=None)
@given(values=values, start=st.integers(0, 8), width=st.integers(0, 8), operator=st.sampled_from([*SPELLINGS]))
@example([(True, True), *[(True, False)] * 30], 0, 8, "eventually")
@example([(True, True)] * 20 + [(False, False)] * 9, 0, 8, "always")
def test_a_spelling_in_the_past_decides_as_stl_does(
    values: list[tuple[bool, bool]], start: int, width: int, operator: str
) -> None:
    last, end = len(values) - 1, start + width
    signals = [{"a": 1.0 if a else -1.0, "b": 1.0 if b else -1.0} for a, b in values]
    trace = LoggedRun({tick: Instant(signals=each) for tick, each in enumerate(signals)}, last)
    text = SPELLINGS[operator].format(end=end * TICK_S, width=width * TICK_S)
    verdict = run(parse_formula(text, VOCABULARY), trace)
    samples = rtamt_oracle.sampled(trace, ["a", "b"], [])
    holds = rtamt_oracle.evaluated(f"{operator}[{start}:{end}](v_b)", samples)
    decided = range(last - end + 1)
    asked = [holds[tick] for tick in decided if values[tick][0]]
    assert verdict.verdict == ("NC" if not asked else "Passed" if all(asked) else "Failed")
