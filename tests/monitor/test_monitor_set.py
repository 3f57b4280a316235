"""Feeding a run: what is refused, what is ignored, when a run is over, and the verdict as data."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import msgspec
import pytest

from pytest_hricdv.monitor import MonitorError, MonitorSet, RequirementResult, Trigger
from tests.monitor.vocabulary import R1, R3, SMALL, Update, judge, requirement

RESPOND = requirement("always(on(a) -> eventually[0:3](p))")
LEVEL = requirement("always(on(m) & m.ok -> m.level < 1)")


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_value_that_is_not_finite_is_an_error(value: float) -> None:
    with pytest.raises(MonitorError, match=r"hand_distance at 1\.5 s is -?(nan|inf): not a finite number"):
        MonitorSet([R3]).signal(1.5, "hand_distance", value)
    with pytest.raises(MonitorError, match=r"m\.level at 1\.5 s is"):
        MonitorSet([LEVEL]).message(1.5, "m", {"ok": True, "level": value})


def test_a_value_of_the_wrong_type_is_an_error() -> None:
    with pytest.raises(MonitorError, match=r"hand_closing at 1\.0 s: expected a bool, got 0\.2 \(float\)"):
        MonitorSet([R3]).signal(1.0, "hand_closing", 0.2)
    with pytest.raises(MonitorError, match=r"hand_distance .* expected a float, got True"):
        MonitorSet([R3]).signal(1.0, "hand_distance", True)


def test_whole_numbers_of_64_bits_are_compared_exactly() -> None:
    other = requirement("always(on(m) & last(m.level) > 0 -> m.level == last(m.level))")
    for second, verdict in ((2**53, "Failed"), (2**53 + 1, "Passed")):
        monitors = MonitorSet([other])
        monitors.message(1.0, "m", {"ok": True, "level": 2**53 + 1})
        monitors.message(2.0, "m", {"ok": True, "level": second})
        assert monitors.finish(3.0)[0].verdict == verdict


def test_a_message_without_a_field_that_is_read_is_an_error() -> None:
    with pytest.raises(MonitorError, match="'m' at 1 s has no field 'level'; its fields: ok"):
        MonitorSet([LEVEL]).message(1, "m", {"ok": True})


def test_a_signal_that_is_read_before_it_has_a_value_is_an_error() -> None:
    monitors = MonitorSet([R3])
    monitors.signal(1.0, "hand_closing", True)
    with pytest.raises(MonitorError, match=r"R3 at 1\.0 s reads hand_distance, which has no value yet"):
        monitors.advance(2.0)


def test_a_signal_that_never_comes_is_an_error_even_if_nothing_triggered() -> None:
    monitors = MonitorSet([R3])
    monitors.signal(0.0, "hand_closing", False)
    with pytest.raises(MonitorError, match="R3 reads hand_distance, which had no value in the whole run"):
        monitors.finish(1.0)


def test_a_division_by_zero_is_an_error_with_its_place() -> None:
    monitors = MonitorSet([requirement("always(x / y > 1 -> p)")])
    for name, value in [("x", 1.0), ("y", 0.0), ("p", True)]:
        monitors.signal(0.0, name, value)
    with pytest.raises(MonitorError, match=r"R at 0\.0 s: .*division by zero"):
        monitors.finish(1.0)


def test_a_monitor_set_is_for_one_run() -> None:
    monitors = MonitorSet([requirement("always(on(a) -> eventually[0:1](on(b)))")])
    monitors.finish(1.0)
    with pytest.raises(MonitorError, match="after the run was finished"):
        monitors.message(2.0, "a", {})
    with pytest.raises(MonitorError, match="after the run was finished"):
        monitors.finish(1.0)


def test_the_next_deadline_is_the_latest_of_the_open_triggers() -> None:
    monitors = MonitorSet([RESPOND, requirement("always(on(b) -> eventually[0:10](p))")])
    monitors.signal(0.0, "p", False)
    assert monitors.next_deadline_s() is None
    monitors.message(1.0, "a", {})
    monitors.message(2.0, "b", {})
    assert monitors.next_deadline_s() == 4.0  # a trigger of the present instant counts after the next advance
    monitors.advance(2.5)
    assert monitors.next_deadline_s() == 12.0
    monitors.signal(3.0, "p", True)
    monitors.advance(3.5)
    assert monitors.next_deadline_s() is None
    assert [verdict.verdict for verdict in monitors.finish(3.5)] == ["Passed", "Passed"]


def test_a_deadline_is_decided_once_time_has_passed_it() -> None:
    monitors = MonitorSet([RESPOND])
    monitors.signal(0.0, "p", False)
    monitors.message(1.0, "a", {})
    monitors.advance(4.0)
    assert monitors.next_deadline_s() == 4.0
    monitors.advance(4.1)
    assert monitors.next_deadline_s() is None


def test_the_result_of_a_verdict_is_what_reports_have() -> None:
    monitors = MonitorSet([R1])
    for name, value in [("leg_held", True), ("leg_torn", False), ("leg_offset", 0.5)]:
        monitors.signal(0.0, name, value)
    monitors.message(1.0, "reading", {"gaze": True, "pressure": True, "location": True, "extra": "ignored"})
    verdict = monitors.finish(20.0)[0]
    assert (verdict.requirement, verdict.history) == ("R1", (Trigger(1.0, 11.0, "failed"),))
    text = msgspec.json.encode(verdict.result)
    assert msgspec.json.decode(text, type=RequirementResult) == verdict.result
    assert json.loads(text) == {
        "verdict": "Failed",
        "triggers": 1,
        "passes": 0,
        "failures": 1,
        "untriggered": 0,
        "pending": 0,
        "violations": [
            {
                "trigger_s": 1.0,
                "time_s": 11.0,
                "values": {
                    "reading.gaze": True,
                    "reading.pressure": True,
                    "reading.location": True,
                    "leg_held": True,
                    "leg_torn": False,
                    "leg_offset": 0.5,
                },
                "margin": -9.0,
                "margin_s": 20.0,
            }
        ],
        "margin": -9.0,
        "margin_time_s": 20.0,
        "near_miss": None,
    }


def test_the_vocabulary_refuses_names_and_types_that_a_formula_cannot_have() -> None:
    assert SMALL.kind("m.level") is float
    assert SMALL.kind("m.nothing") is None
    for signals, problem in [
        ({"until": bool}, "keyword"),
        ({"1x": bool}, "letters, digits"),
        ({"x": int}, "bool, float or str"),
    ]:
        with pytest.raises(ValueError, match=problem):
            type(SMALL)(signals=signals)  # type: ignore[arg-type]


@pytest.mark.parametrize("time_s", [4.7e9, 1e200])
def test_a_time_of_more_than_a_hundred_years_is_an_error(time_s: float) -> None:
    monitors = MonitorSet([requirement("always(p -> x < 1)")])
    with pytest.raises(MonitorError, match=r"a time has to be at most 4\.6e\+09 s, got 4700000000|got 1e\+200"):
        monitors.signal(time_s, "p", True)
    monitors.signal(4.6e9, "p", True)
    monitors.signal(4.6e9, "x", 0.0)
    [verdict] = monitors.finish(4.61e9)
    assert (verdict.verdict, verdict.history[0].begin_s) == ("Passed", 4.6e9)


# --- signals that a requirement shows in addition to those that it reads


def test_a_violation_has_the_largest_value_of_a_shown_signal_while_it_lasts() -> None:
    watched = replace(requirement("always(p -> x >= 1)"), shows=("y",))
    updates: list[Update] = [(0.0, "p", True), (0.0, "x", 2.0), (0.0, "y", 9.0)]
    updates += [(1.0, "y", 0.0), (2.0, "x", 0.0), (2.5, "y", -3.0), (3.0, "y", 2.0), (4.0, "x", 1.0), (4.0, "y", 8.0)]
    updates += [(5.0, "x", 0.0), (6.0, "p", False)]
    violations = judge(watched, updates, 7.0).violations
    assert [dict(violation.values) for violation in violations] == [
        {"p": True, "x": 0.0, "y": -3.0},
        {"p": True, "x": 0.0, "y": 8.0},
    ]
