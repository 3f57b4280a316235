"""Conditions outside of requirements: when they become true and false, online and in logged runs."""

from __future__ import annotations

import math
from functools import partial

import pytest
from hypothesis import HealthCheck, given, settings

from pytest_hricdv.monitor import (
    MonitorError,
    MonitorSet,
    parse_condition,
    watch,
)
from pytest_hricdv.monitor.build import equal, field, on
from pytest_hricdv.monitor.node import PastFormula
from tests.monitor.logged_run import TICK_S, LoggedRun
from tests.monitor.logs import feed_trace, log_of
from tests.monitor.reference import ReferenceEvaluator
from tests.monitor.strategies import pasts, small_traces
from tests.monitor.vocabulary import SMALL, Update, feed

RUNS = settings(suppress_health_check=[HealthCheck.too_slow])
Changes = list[tuple[float, bool]]


def changes(text: str, updates: list[Update], end_s: float) -> Changes:
    """The calls of a condition that is watched while a run is fed."""
    calls: Changes = []
    monitors = MonitorSet()
    monitors.watch(parse_condition(text, SMALL), lambda time_s, holds: calls.append((time_s, holds)))
    feed(monitors, updates)
    monitors.finish(end_s)
    return calls


@given(condition=pasts, trace=small_traces)
@RUNS
def test_a_random_condition_has_the_truth_of_the_reference(condition: PastFormula, trace: LoggedRun) -> None:
    truth = ReferenceEvaluator(trace).truth(condition)
    monitors, calls = MonitorSet(), Changes()
    monitor = monitors.watch(condition, lambda time_s, holds: calls.append((time_s, holds)))
    feed_trace(monitors, trace)
    assert monitor.holds == truth[2 * trace.last + 1]
    for tick in range(trace.last):
        assert monitor.holds_at(tick * TICK_S) == truth[2 * tick + 1]
        assert monitor.holds_at((tick + 0.5) * TICK_S) == truth[2 * tick + 2]
    assert [time_s for time_s, _ in calls] == sorted(time_s for time_s, _ in calls)
    assert [holds for _, holds in calls] == [number % 2 == 0 for number in range(len(calls))]
    assert monitor.began_s == tuple(time_s for time_s, holds in calls if holds)
    logged = watch(condition, log_of(trace))
    assert (logged.began_s, logged.holds) == (monitor.began_s, monitor.holds)


def test_a_state_is_told_when_it_begins_and_when_it_ends() -> None:
    updates: list[Update] = [(time_s, "w", {"name": name}) for time_s, name in [(1.0, "i"), (2.0, "i"), (3.5, "j")]]
    assert changes('w == "i"', updates, 9.0) == [(1.0, True), (3.5, False)]


def test_an_instant_is_told_with_both_ends_and_two_messages_at_one_time_as_one() -> None:
    updates: list[Update] = [(1.0, "a", {}), (2.0, "a", {}), (2.0, "a", {})]
    assert changes("on(a)", updates, 9.0) == [(1.0, True), (1.0, False), (2.0, True), (2.0, False)]


def test_all_conditions_of_a_run_are_told_in_the_order_of_time() -> None:
    calls: list[str] = []

    def note(text: str, time_s: float, holds: bool) -> None:
        calls.append(f"{time_s} {text}")

    monitors = MonitorSet()
    for text in ("once[0:5](on(a))", "once[0:1](on(a))", "once[0:3](on(a))"):
        monitors.watch(parse_condition(text, SMALL), partial(note, text))
    monitors.message(1.0, "a", {})
    monitors.finish(9.0)
    assert calls[3:] == ["2.0 once[0:1](on(a))", "4.0 once[0:3](on(a))", "6.0 once[0:5](on(a))"]


def test_what_reads_a_value_that_is_not_there_yet_is_false() -> None:
    assert changes("m.ok", [(1.0, "a", {}), (2.0, "m", {"ok": True, "level": 0.0})], 3.0) == [(2.0, True)]
    assert changes("m.level < 1 | p", [(0.0, "p", True), (2.0, "m", {"ok": True, "level": 0.0})], 3.0) == [(2.0, True)]


def test_a_condition_is_asked_while_the_run_goes_on() -> None:
    monitors = MonitorSet()
    monitor = monitors.watch((on("a") | equal(field("w.name"), "i")).past)
    monitors.message(1.0, "w", {"name": "i"})
    assert not monitor.holds  # the instant is not over
    monitors.advance(1.5)
    assert monitor.holds
    assert (monitor.holds_at(0.999), monitor.holds_at(1.0), monitor.holds_at(math.inf)) == (False, True, True)


def test_a_signal_that_never_comes_is_an_error_that_names_the_condition() -> None:
    monitors = MonitorSet()
    monitors.watch(parse_condition("x < 1", SMALL))
    with pytest.raises(MonitorError, match="condition x < 1 reads x, which had no value in the whole run"):
        monitors.finish(1.0)


def test_a_text_of_the_wrong_type_is_refused() -> None:
    monitors = MonitorSet()
    monitors.watch(parse_condition('s == "i" & w == "i"', SMALL))
    with pytest.raises(MonitorError, match=r"s at 0\.0 s: expected a str, got 1\.0 \(float\)"):
        monitors.signal(0.0, "s", 1.0)
    with pytest.raises(MonitorError, match=r"w\.name at 0\.0 s: expected a str, got None"):
        monitors.message(0.0, "w", {"name": None})
