"""Patterns: each equals the formula written by hand, judges runs as its words say, and refuses wrong arguments."""

from __future__ import annotations

import doctest
import importlib
import math
import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from pytest_hricdv.monitor import Log, RequirementError, check_requirement, evaluate, parse_condition, parse_formula
from pytest_hricdv.monitor.build import field, on, once, previously, requirement, rise, signal
from pytest_hricdv.monitor.dsl import TruthValue
from pytest_hricdv.monitor.formula import Formula
from pytest_hricdv.monitor.node import PastFormula
from pytest_hricdv.monitor.patterns import (
    PATTERNS,
    PatternError,
    absence,
    contact_pressure,
    existence,
    hand_guiding,
    power_and_force,
    precedence,
    protective_separation,
    protective_stop,
    response,
    speed_and_separation,
    universality,
)
from tests.monitor.logs import Logged
from tests.monitor.strategies import pasts
from tests.monitor.vocabulary import SMALL

p, q, x, y = signal("p"), signal("q"), signal("x"), signal("y")
a, b, m = on("a"), on("b"), on("m")

Update = tuple[float, str, Any]


def wrong(argument: Any) -> Any:
    """An argument of a type that the patterns refuse."""
    return argument


def log(updates: Sequence[Update], end_s: float = 20.0) -> Log:
    """A run of the small vocabulary: (time, signal, value), or (time, topic, fields). Signals begin at 0 or False."""
    signals: dict[str, tuple[list[float], list[Any]]] = {name: ([0.0], [0.0]) for name in ("p", "q", "x", "y")}
    for time_s, name, value in updates:
        if not isinstance(value, Mapping):
            signals[name][0].append(time_s)
            signals[name][1].append(float(value))
    return Log(signals, [Logged(*update) for update in updates if isinstance(update[2], Mapping)], end_s)


def messages(**times_s: Sequence[float]) -> list[Update]:
    """Messages of topics, in the order of time."""
    return sorted(
        ((time_s, topic, {}) for topic, times in times_s.items() for time_s in times), key=lambda message: message[0]
    )


def pulse(name: str, start_s: float, end_s: float) -> list[Update]:
    return [(start_s, name, True), (end_s, name, False)]


def levels(**steps: Sequence[tuple[float, float]]) -> list[Update]:
    """Values of numbers over time: name -> (time, value)."""
    return [(time_s, name, value) for name, values in steps.items() for time_s, value in values]


def verdict(formula: Formula, updates: Sequence[Update]) -> str:
    [judged] = evaluate([requirement("P", "A pattern", formula)], log(updates))
    return judged.verdict


@pytest.mark.parametrize(
    ("built", "written"),
    [
        (response(a, b, within_s=30), "always(on(a) -> eventually[0:30](on(b)))"),
        (response(p, x < 1, within_s=3, after_s=1), "always(p -> eventually[1:3](x < 1))"),
        (precedence(a, b), "always(on(b) -> once(on(a)))"),
        (precedence(a, p), "always(p -> once(on(a)))"),
        (precedence(a, p, within_s=2), "always(rise(p) -> once[0:2](on(a)))"),
        (precedence(a, b, after=q), "always(on(b) -> !rise(q) since on(a))"),
        (precedence(a, b, within_s=2, after=m), "always(on(b) -> once[0:2](on(a)) & (!on(m) since on(a)))"),
        (absence(a, during=p), "always(p -> !on(a))"),
        (absence(a, after=b), "always(on(b) -> always[0:inf](!on(a)))"),
        (absence(a, after=b, until=m), "always(on(b) -> always(!on(a)) until on(m))"),
        (absence(p, after=b, for_s=5), "always(on(b) -> always[0:5](!p))"),
        (universality(q, during=p), "always(p -> q)"),
        (universality(x < 1, after=b), "always(on(b) -> always[0:inf](x < 1))"),
        (universality(q, after=b, until=m), "always(on(b) -> always(q) until on(m))"),
        (universality(q, after=b, for_s=5), "always(on(b) -> always[0:5](q))"),
        (existence(a, at_most=2), "always(on(a) -> count(on(a)) <= 2)"),
        (existence(p, at_most=2, within_s=9), "always(rise(p) -> count[0:9](rise(p)) <= 2)"),
        (
            existence(a, at_most=1, after=b, until=m),
            "always(on(b) -> always(!(on(a) & !on(b) & previously(!on(b) since on(a)))) until on(m))",
        ),
        (speed_and_separation(x, y, stop_distance_m=0.3), "always(y < 0.3 -> x <= 0)"),
        (
            speed_and_separation(x, y, stop_distance_m=0.3, slow_distance_m=1, slow_speed=0.25, standstill=0.01),
            "always(y < 1 -> y >= 0.3 & x <= 0.25 | x <= 0.01)",
        ),
        (
            speed_and_separation(x, y, stop_distance_m=0.2 + 0.3 * x, slow_distance_m=1, slow_speed=0.25),
            "always(y < 1 | y < 0.2 + 0.3 * x -> y >= 0.2 + 0.3 * x & x <= 0.25 | x <= 0)",
        ),
        (power_and_force(x, limit_n=30), "always(x > 0 -> x <= 30)"),
        (
            power_and_force(x, limit_n=30, transient_limit_n=60, transient_s=0.5),
            "always(x > 0 -> x <= 60 & !(x > 30 [for 0.5]))",
        ),
        (contact_pressure(x, limit_n_cm2=y), "always(x > 0 -> x <= y)"),
        (protective_stop(p, x, within_s=0.5, standstill=0.01), "always(historically[0:0.5](p) -> x <= 0.01)"),
        (protective_stop(a, x, within_s=1, until=b), "always(historically[0:1](!on(b) since on(a)) -> x <= 0)"),
        (hand_guiding(p, q), "always(q -> p)"),
        (hand_guiding(p, x > 0, within_s=0.2), "always(x > 0 -> once[0:0.2](p))"),
    ],
    ids=str,
)
def test_a_pattern_is_the_formula_written_by_hand(built: Formula, written: str) -> None:
    assert built == parse_formula(written, SMALL)


RESPONSE = response(a, b, within_s=3, after_s=1)
PRECEDENCE = precedence(a, b)
RECENT = precedence(a, b, within_s=2, after=m)
ABSENCE = absence(b, after=a, until=m)
UNIVERSALITY = universality(p, during=q)
EXISTENCE = existence(b, at_most=2)
RATE = existence(b, at_most=2, within_s=3)
ONCE = existence(b, at_most=1, after=a)
TWICE = existence(b, at_most=2, after=a, until=m)
SEPARATION = speed_and_separation(x, y, stop_distance_m=0.3, slow_distance_m=1, slow_speed=0.25)
FORCE = power_and_force(x, limit_n=30, transient_limit_n=60, transient_s=0.5)
STOP = protective_stop(p, x, within_s=1)
LATCHED = protective_stop(a, x, within_s=1, until=b)
GUIDING = hand_guiding(p, x > 0, within_s=0.5)


@pytest.mark.parametrize(
    ("formula", "updates", "expected"),
    [
        (RESPONSE, messages(a=[5], b=[7]), "Passed"),
        (RESPONSE, messages(a=[5], b=[5.5]), "Failed"),  # too early
        (RESPONSE, messages(a=[5], b=[9]), "Failed"),  # too late
        (RESPONSE, messages(b=[7]), "NC"),
        (RESPONSE, messages(a=[19]), "NC"),  # undecided at the end of the run
        (PRECEDENCE, messages(a=[1], b=[5, 6]), "Passed"),
        (PRECEDENCE, messages(a=[5], b=[4]), "Failed"),
        (PRECEDENCE, messages(a=[5]), "NC"),
        (RECENT, messages(a=[4], b=[5]), "Passed"),
        (RECENT, messages(a=[4], b=[7]), "Failed"),  # too long ago
        (RECENT, messages(a=[4], m=[4.5], b=[5]), "Failed"),  # from before the scope
        (ABSENCE, messages(a=[1], m=[4], b=[5]), "Passed"),
        (ABSENCE, messages(a=[1], m=[4], b=[3]), "Failed"),
        (ABSENCE, messages(a=[1]), "Passed"),  # to the end of the run
        (ABSENCE, messages(b=[3]), "NC"),
        (absence(b, after=a, for_s=2), messages(a=[1], b=[4]), "Passed"),
        (absence(b, after=a, for_s=2), messages(a=[1], b=[3]), "Failed"),
        (absence(b, during=p), [*pulse("p", 1, 3), *messages(b=[2])], "Failed"),
        (absence(b, during=p), [*pulse("p", 1, 3), *messages(b=[4])], "Passed"),
        (UNIVERSALITY, [*pulse("p", 1, 9), *pulse("q", 2, 4)], "Passed"),
        (UNIVERSALITY, [*pulse("p", 1, 3), *pulse("q", 2, 4)], "Failed"),
        (UNIVERSALITY, pulse("p", 1, 3), "NC"),
        (EXISTENCE, messages(b=[1, 5]), "Passed"),
        (EXISTENCE, messages(b=[1, 5, 5]), "Failed"),  # two at one instant
        (EXISTENCE, messages(a=[1]), "NC"),
        (RATE, messages(b=[1, 2, 6, 7]), "Passed"),
        (RATE, messages(b=[1, 2, 4]), "Failed"),
        (ONCE, messages(a=[1, 6], b=[0.5, 2, 7]), "Passed"),
        (ONCE, messages(a=[1, 6], b=[2, 7, 8]), "Failed"),
        (ONCE, messages(b=[2, 7, 8]), "NC"),
        (ONCE, messages(a=[1, 6], b=[2, 6]), "Passed"),  # at the instant of the next one: the first of its scope
        (ONCE, messages(a=[1], b=[1, 6]), "Failed"),
        (TWICE, messages(a=[1], b=[2, 3], m=[4]), "Passed"),
        (TWICE, messages(a=[1], b=[2, 3, 5], m=[4]), "Passed"),
        (TWICE, messages(a=[1], b=[2, 3, 3.5], m=[4]), "Failed"),
        (SEPARATION, levels(y=[(0, 2), (3, 0.8)], x=[(0, 1), (2, 0.2)]), "Passed"),
        (SEPARATION, levels(y=[(0, 2), (3, 0.8)], x=[(0, 1), (4, 0.2)]), "Failed"),  # fast in the slow zone
        (SEPARATION, levels(y=[(0, 0.8), (3, 0.2)], x=[(0, 0.1)]), "Failed"),  # moves in the stop zone
        (SEPARATION, levels(y=[(0, 0.8), (3, 0.2)], x=[(0, 0.1), (2.5, 0)]), "Passed"),
        (SEPARATION, levels(y=[(0, 2)], x=[(0, 1)]), "NC"),
        (FORCE, levels(x=[(1, 20), (2, 0)]), "Passed"),
        (FORCE, levels(x=[(1, 50), (1.4, 20), (2, 0)]), "Passed"),  # transient
        (FORCE, levels(x=[(1, 50), (1.6, 20), (2, 0)]), "Failed"),  # too long for that
        (FORCE, levels(x=[(1, 61), (1.1, 0)]), "Failed"),
        (FORCE, levels(x=[(1, 0)]), "NC"),
        (STOP, [*pulse("p", 3, 9), *levels(x=[(0, 1), (3.5, 0), (9.5, 1)])], "Passed"),
        (STOP, [*pulse("p", 3, 9), *levels(x=[(0, 1), (4.5, 0)])], "Failed"),  # stops too late
        (STOP, [*pulse("p", 3, 9), *levels(x=[(0, 1), (3.5, 0), (8, 1)])], "Failed"),  # moves again
        (STOP, [*pulse("p", 3, 3.5), *levels(x=[(0, 1)])], "NC"),  # shorter than the stop may take
        (LATCHED, [*messages(a=[3], b=[8]), *levels(x=[(0, 1), (4, 0), (8, 1)])], "Passed"),
        (LATCHED, [*messages(a=[3], b=[8]), *levels(x=[(0, 1), (4, 0), (7, 1)])], "Failed"),
        (LATCHED, levels(x=[(0, 1)]), "NC"),
        (GUIDING, [*pulse("p", 1, 5), *levels(x=[(1, 1), (5.4, 0)])], "Passed"),
        (GUIDING, [*pulse("p", 1, 5), *levels(x=[(1, 1), (5.6, 0)])], "Failed"),
        (GUIDING, pulse("p", 1, 5), "NC"),
    ],
)
def test_a_pattern_judges_a_run(formula: Formula, updates: Sequence[Update], expected: str) -> None:
    assert verdict(formula, updates) == expected


@given(st.sets(st.integers(1, 30), max_size=8), st.sets(st.integers(1, 30), max_size=4), st.integers(1, 3))
def test_a_bounded_existence_counts_the_events_of_each_scope(events: set[int], starts: set[int], at_most: int) -> None:
    updates = messages(b=sorted(events), a=sorted(starts))
    [judged] = evaluate([requirement("P", "", existence(b, at_most=at_most, after=a))], log(updates, end_s=40.0))
    ends = [*sorted(starts)[1:], math.inf]
    scopes = [
        sum(start <= event < end for event in events) for start, end in zip(sorted(starts), ends, strict=bool(starts))
    ]
    assert judged.verdict == ("NC" if not scopes else "Failed" if max(scopes) > at_most else "Passed")


CASES: dict[str, Callable[[TruthValue, TruthValue], Formula]] = {
    "response": lambda condition, other: response(condition, other, within_s=2),
    "precedence": lambda condition, other: precedence(condition, other, within_s=2, after=a),
    "absence": lambda condition, other: absence(condition, during=other),
    "universality": lambda condition, other: universality(condition, after=other, for_s=2),
    "existence": lambda condition, other: existence(condition, at_most=2, after=other),
    "speed_and_separation": lambda condition, other: speed_and_separation(x, y, stop_distance_m=1),
    "protective_separation": lambda condition, other: protective_separation(
        x, y, v_h=1.5, t_r=0.5, t_s=0.5, v_r=x, s_s=y, z_d=0.25
    ),
    "power_and_force": lambda condition, other: power_and_force(x, limit_n=1),
    "contact_pressure": lambda condition, other: contact_pressure(x, limit_n_cm2=1),
    "protective_stop": lambda condition, other: protective_stop(condition, x, within_s=1, until=other),
    "hand_guiding": lambda condition, other: hand_guiding(condition, other, within_s=1),
}


@pytest.mark.parametrize("name", CASES)
@given(condition=pasts, other=pasts)
def test_a_pattern_of_any_conditions_can_be_written_and_read_again(
    name: str, condition: PastFormula, other: PastFormula
) -> None:
    assume(is_accepted(condition) and is_accepted(other))
    if name in ("universality", "hand_guiding"):
        assume(not condition.is_instantaneous and not other.is_instantaneous)
    check_requirement(requirement("P", "", CASES[name](TruthValue(condition), TruthValue(other))), SMALL)


def is_accepted(condition: PastFormula) -> bool:
    """Whether a random condition is one that the language accepts: it may ask that an instant lasts."""
    try:
        parse_condition(str(condition), SMALL)
    except RequirementError:
        return False
    return True


@pytest.mark.parametrize("at_most", range(1, 21))
@pytest.mark.parametrize("until", [None, b], ids=["to the end", "until"])
def test_as_many_events_as_a_scope_allows_can_be_asked_for_in_python(at_most: int, until: TruthValue | None) -> None:
    events = {"a message": m, "with a field": m & field("m.ok"), "an edge": rise(~(p & previously(once(q, 0, 3))))}
    for event in events.values():
        for after in (a, q, rise(~q)):
            check_requirement(requirement("P", "", existence(event, at_most=at_most, after=after, until=until)), SMALL)


@pytest.mark.parametrize(
    ("call", "argument", "says"),
    [
        (lambda: response(a, b, within_s=-3), "within_s", "a finite number of at least 0, got -3"),
        (lambda: response(a, b, within_s=math.inf), "within_s", "a finite number of at least 0, got inf"),
        (lambda: response(a, b, within_s=wrong("30")), "within_s", "expected a number, got '30'"),
        (lambda: response(a, b, within_s=True), "within_s", "expected a number, got True"),
        (lambda: response(a, b, within_s=0), "within_s", "a time after the trigger"),
        (lambda: response(a, b, within_s=1, after_s=2), "within_s", "not before after_s, got 1"),
        (lambda: response(wrong("a"), b, within_s=1), "trigger", "expected a condition, such as on(topic), got 'a'"),
        (lambda: absence(a), "", "no scope; expected `during=condition` or `after=event`"),
        (lambda: absence(a, during=p, until=b), "until", "does not go with `during`"),
        (lambda: absence(a, after=b, until=m, for_s=1), "for_s", "expected one of until and for_s"),
        (lambda: absence(a, after=b, for_s=0), "for_s", "above 0"),
        (lambda: universality(a, during=p), "condition", "`on(a)` is true for single instants only"),
        (lambda: existence(a, at_most=0), "at_most", "for 0, use absence"),
        (lambda: existence(a, at_most=wrong(1.5)), "at_most", "expected a whole number, got 1.5"),
        (lambda: existence(a, at_most=21, after=b), "at_most", "at most 20 in a scope"),
        (lambda: existence(a, at_most=1, until=b), "until", "there is no `after`"),
        (lambda: existence(a, at_most=1, after=b, within_s=1), "within_s", "one of within_s and after"),
        (
            lambda: speed_and_separation(wrong(a), y, stop_distance_m=1),
            "speed",
            "expected a signal or field that is a number",
        ),
        (
            lambda: speed_and_separation(x, y, stop_distance_m=wrong(p < 1)),
            "stop_distance_m",
            "expected a signal or field",
        ),
        (
            lambda: speed_and_separation(x, y, stop_distance_m=1, slow_speed=1),
            "slow_speed",
            "both slow_distance_m and slow_speed",
        ),
        (
            lambda: speed_and_separation(x, y, stop_distance_m=1, slow_distance_m=1, slow_speed=1),
            "slow_distance_m",
            "more than stop_distance_m, which is 1, got 1",
        ),
        (lambda: power_and_force(x, limit_n=1, transient_s=1), "transient_s", "both transient_limit_n and transient_s"),
        (
            lambda: power_and_force(x, limit_n=wrong(None)),
            "limit_n",
            "expected a signal or field that is a number or a number",
        ),
        (lambda: protective_stop(a, x, within_s=1), "condition", "`on(a)` is true for single instants only"),
        (lambda: hand_guiding(p, a), "moving", "`on(a)` is true for single instants only"),
    ],
)
def test_a_wrong_argument_is_refused_by_name(call: Callable[[], Formula], argument: str, says: str) -> None:
    with pytest.raises(PatternError, match=re.escape(says)) as caught:
        call()
    assert caught.value.argument == argument


def test_a_limit_of_force_has_to_be_given() -> None:
    with pytest.raises(TypeError, match="limit_n"):
        power_and_force(x)  # type: ignore[call-arg]


@pytest.mark.parametrize("module", ["", ".temporal", ".collaboration"])
def test_the_examples_of_the_docstrings_give_what_they_show(module: str) -> None:
    results = doctest.testmod(importlib.import_module(f"pytest_hricdv.monitor.patterns{module}"))
    assert not results.failed
    assert results.attempted


@pytest.mark.parametrize("name", PATTERNS)
def test_each_pattern_says_its_formula_scope_and_source(name: str) -> None:
    text = PATTERNS[name].__doc__ or ""
    assert [part for part in ("Formula", "Scope: ", "Source: ", ">>> ") if part not in text] == []
