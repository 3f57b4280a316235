"""The monitors, fed and on logged runs, compared with the reference evaluator: case study and random formulas."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from pytest_hricdv.monitor import Requirement, evaluate
from pytest_hricdv.monitor.formula import Formula
from tests.monitor.logged_run import LoggedRun
from tests.monitor.logs import log_of, run, summary
from tests.monitor.reference import ReferenceEvaluator
from tests.monitor.strategies import formulas, small_traces, table_traces
from tests.monitor.vocabulary import R1, R2, R3, R4, R5

RUNS = settings(suppress_health_check=[HealthCheck.too_slow])


def agrees(formula: Formula, trace: LoggedRun, shows: tuple[str, ...] = ()) -> None:
    expected = ReferenceEvaluator(trace).judge(formula, shows)
    assert summary(run(formula, trace, shows=shows)) == expected
    [logged] = evaluate([Requirement("R", "", "", "", formula, shows)], log_of(trace))
    assert summary(logged) == expected


# --- the case study


@pytest.mark.parametrize("watched", [R1, R2, R3, R4, R5], ids=lambda watched: watched.id)
@given(trace=table_traces)
@RUNS
def test_the_case_study_is_judged_as_by_the_reference(watched: Requirement, trace: LoggedRun) -> None:
    agrees(watched.formula, trace)


# --- random formulas


@given(formula=formulas, trace=small_traces)
@RUNS
def test_a_random_formula_is_judged_as_by_the_reference(formula: Formula, trace: LoggedRun) -> None:
    agrees(formula, trace, shows=("x", "y"))


# --- what must not change a verdict


@given(formula=formulas, trace=small_traces, shift_s=st.sampled_from([0.1, 17.3, 299.999999999]))
@RUNS
def test_a_run_shifted_in_time_has_the_same_verdict(formula: Formula, trace: LoggedRun, shift_s: float) -> None:
    here, there = run(formula, trace), run(formula, trace, shift_s)
    assert there == replace(
        here,
        margin_time_s=None if here.margin_time_s is None else round(here.margin_time_s + shift_s, 9),
        violations=tuple(
            replace(
                v,
                trigger_s=round(v.trigger_s + shift_s, 9),
                time_s=round(v.time_s + shift_s, 9),
                margin_s=None if v.margin_s is None else round(v.margin_s + shift_s, 9),
                values_s={name: round(time_s + shift_s, 9) for name, time_s in v.values_s.items()},
            )
            for v in here.violations
        ),
        history=tuple(
            replace(trigger, begin_s=round(trigger.begin_s + shift_s, 9), end_s=round(trigger.end_s + shift_s, 9))
            for trigger in here.history
        ),
    )
