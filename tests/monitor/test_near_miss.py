"""The nearest miss of a requirement that was not triggered: its time, what was false, and by how much."""

from __future__ import annotations

import math
from collections.abc import Sequence

import pytest
from hypothesis import HealthCheck, assume, given, settings

from pytest_hricdv.monitor import MonitorSet
from pytest_hricdv.monitor.antecedent import near_miss
from pytest_hricdv.monitor.formula import Formula
from pytest_hricdv.monitor.log import Log
from pytest_hricdv.monitor.logged import explain
from pytest_hricdv.monitor.verdict import NearMiss
from tests.monitor.logged_run import TICK_S, LoggedRun
from tests.monitor.logs import Logged, log_of, run
from tests.monitor.reference import ReferenceEvaluator
from tests.monitor.strategies import formulas, small_traces
from tests.monitor.vocabulary import R1, R3, requirement

Series = tuple[Sequence[float], Sequence[float]]


def reading(time_s: float, gaze: bool, pressure: bool, location: bool) -> Logged:
    return Logged(time_s, "reading", {"gaze": gaze, "pressure": pressure, "location": location})


def missed(text: str, end_s: float = 10.0, messages: Sequence[Logged] = (), **signals: Series) -> NearMiss:
    return near_miss(requirement(text).formula.antecedent, Log(signals, messages, end_s))


def test_the_conjunct_that_failed_alone_is_named_with_its_time() -> None:
    log = Log(
        {}, [reading(3.0, True, False, False), reading(5.0, True, False, True), reading(8.0, False, True, True)], 9
    )
    assert near_miss(R1.formula.antecedent, log) == NearMiss(5.0, ("reading.pressure",), None)


def test_the_distance_counts_the_hysteresis_that_is_in_the_way() -> None:
    x: Series = ([0.0, 1.0], [0.0, 0.003])
    miss = missed("always(x > 0.001 [hysteresis 0.004] -> p)", x=x)
    assert (miss.time_s, miss.missing) == (1.0, ("x > 0.001 [hysteresis 0.004]",))
    assert miss.distance == pytest.approx(0.002)
    negated = missed("always(!(x < 1 [hysteresis 0.5]) -> p)", x=([0.0], [0.75]))
    assert negated == NearMiss(0.0, ("!(x < 1 [hysteresis 0.5])",), 0.25)


def test_a_conjunct_that_is_guarded_by_another_is_no_error() -> None:
    miss = missed("always(y != 0 & x / y > 1 -> p)", x=([0.0], [1.0]), y=([0.0], [0.0]))
    assert miss.missing == ("y != 0", "x / y > 1")


def test_only_requirements_that_were_never_triggered_are_explained() -> None:
    log = Log({"hand_closing": ([0.0], [0.0]), "hand_distance": ([0.0], [1.0])}, [reading(1.0, True, True, True)], 2.0)
    monitors = MonitorSet([R1, R3])
    for name, value in [("hand_closing", False), ("hand_distance", 1.0)]:
        monitors.signal(0.0, name, value)
    for name, value in [("leg_held", True), ("leg_torn", False), ("leg_offset", 0.0)]:
        monitors.signal(0.0, name, value)
    monitors.message(1.0, "reading", {"gaze": True, "pressure": True, "location": True})
    pending, unchecked = explain(monitors.finish(2.0), (R1, R3), log)
    assert (pending.verdict, pending.triggers, pending.near_miss) == ("NC", 1, None)
    assert unchecked.near_miss == NearMiss(0.0, ("hand_closing",), None)


SEARCHES = settings(suppress_health_check=[HealthCheck.too_slow])


def agrees(formula: Formula, trace: LoggedRun) -> None:
    assume(run(formula, trace).untriggered)
    miss = near_miss(formula.antecedent, log_of(trace))
    tick, missing, distance = ReferenceEvaluator(trace).near_miss(formula.antecedent)
    assert (miss.time_s, list(miss.missing)) == (tick * TICK_S, missing)
    assert miss.distance == pytest.approx(distance, abs=1e-12)
    assert miss.missing
    assert miss.distance is None or (miss.distance >= 0 and math.isfinite(miss.distance))


@given(formula=formulas, trace=small_traces)
@SEARCHES
def test_a_random_formula_has_the_nearest_miss_of_the_reference(formula: Formula, trace: LoggedRun) -> None:
    agrees(formula, trace)
