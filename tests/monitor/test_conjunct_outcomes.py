"""What the conjuncts of an antecedent were in a run: true, false, or both."""

from __future__ import annotations

from hypothesis import HealthCheck, given, settings

from pytest_hricdv.monitor.antecedent import conjunct_outcomes
from pytest_hricdv.monitor.formula import Formula
from pytest_hricdv.monitor.log import Log
from tests.monitor.logged_run import LoggedRun
from tests.monitor.logs import log_of
from tests.monitor.reference import ReferenceEvaluator
from tests.monitor.strategies import formulas, small_traces
from tests.monitor.vocabulary import R1

SEARCHES = settings(suppress_health_check=[HealthCheck.too_slow])


def test_a_message_is_there_for_an_instant_and_a_field_has_no_value_before_it() -> None:
    antecedent = R1.formula.antecedent
    silent = conjunct_outcomes(antecedent, Log({}, [], 9.0))
    assert silent == {
        "on(reading)": {False},
        "reading.gaze": frozenset(),
        "reading.pressure": frozenset(),
        "reading.location": frozenset(),
    }


def agrees(formula: Formula, trace: LoggedRun) -> None:
    outcomes = conjunct_outcomes(formula.antecedent, log_of(trace))
    assert outcomes == ReferenceEvaluator(trace).outcomes(formula.antecedent)


@given(formula=formulas, trace=small_traces)
@SEARCHES
def test_a_random_formula_has_the_outcomes_of_the_reference(formula: Formula, trace: LoggedRun) -> None:
    agrees(formula, trace)
