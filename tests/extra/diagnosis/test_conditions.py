"""The shortest condition that holds at some moments and not at others."""

from __future__ import annotations

from collections.abc import Mapping

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.diagnosis.conditions import Examples, LearnedCondition, RunMoment, condition_for, truths
from pytest_hricdv.extra.diagnosis.triage import LoggedMessage
from pytest_hricdv.monitor import Log, Vocabulary

VOCABULARY = Vocabulary(
    {"gripped": bool, "speed": float, "place": str},
    {"state": {"name": str}, "ask": {}, "reading": {"gaze": bool, "force": float}},
)
Events = Mapping[float, tuple[str, object]]


def log(*events: tuple[float, str, object]) -> Log:
    """Events: time (s), a signal with its value, or a topic with its fields."""
    signals: dict[str, tuple[list[float], list[float]]] = {}
    messages = []
    for time_s, name, value in events:
        if isinstance(value, dict):
            messages.append(LoggedMessage(time_s, name, value))
        else:
            series = signals.setdefault(name, ([], []))
            series[0].append(time_s)
            series[1].append(value)  # type: ignore[arg-type]
    return Log(signals, messages, 20.0)


def learned(inside: list[Log], outside: list[Log], elsewhere: list[Log] | None = None) -> LearnedCondition | None:
    """From each log at 10 s."""
    logs = {str(number): one for number, one in enumerate([*inside, *outside, *(elsewhere or [])])}
    moments = [RunMoment(name, 10.0) for name in logs]
    first, second = len(inside), len(inside) + len(outside)
    examples = Examples(tuple(moments[:first]), tuple(moments[first:second]), tuple(moments[second:]))
    return condition_for(examples, logs, VOCABULARY)


def state(name: str, time_s: float = 1.0) -> tuple[float, str, object]:
    return time_s, "state", {"name": name}


@pytest.mark.parametrize(
    ("inside", "outside", "text"),
    [
        ([[state("go")], [state("go")]], [[state("stop")]], 'state.name == "go"'),
        ([[state("go"), state("stop", 5.0)]], [[state("stop")]], 'once(state.name == "go")'),
        ([[(1.0, "gripped", 1.0)]], [[(1.0, "gripped", 0.0)]], "gripped"),
        ([[(1.0, "gripped", 0.0)]], [[(1.0, "gripped", 1.0)]], "!gripped"),
        ([[(1.0, "place", "hall")]], [[(1.0, "place", "cellar")]], 'place == "hall"'),
        ([[(1.0, "ask", {})]], [[state("go")]], "once(on(ask))"),
        ([[(9.5, "ask", {})], [(9.2, "ask", {})]], [[(2.0, "ask", {})]], "once[0:1](on(ask))"),
        ([[(1.0, "speed", 0.4)], [(1.0, "speed", 0.5)]], [[(1.0, "speed", 0.1)]], "speed >= 0.2"),
        (
            [[state("go"), (1.0, "gripped", 1.0)]],
            [[state("go"), (1.0, "gripped", 0.0)], [state("stop"), (1.0, "gripped", 1.0)]],
            'state.name == "go" & gripped',
        ),
        (
            [[state("a"), (1.0, "place", "hall")], [state("b"), (1.0, "place", "hall")]],
            [[state("c"), (1.0, "place", "hall")]],
            '!once(state.name == "c")',
        ),
        (
            [[state("a")], [state("b")]],
            [[state("c")], [state("d")], [state("a", 0.5), state("c")], [state("c", 0.5), state("d")]],
            'state.name == "a" | state.name == "b"',
        ),
    ],
)
def test_the_shortest_formula(
    inside: list[list[tuple[float, str, object]]], outside: list[list[tuple[float, str, object]]], text: str
) -> None:
    assert learned([log(*one) for one in inside], [log(*one) for one in outside]) == LearnedCondition(text)


NAMES = st.sampled_from(["go", "stop", "wait"])
RUNS = st.builds(
    lambda first, second, is_gripped, speed: log(
        state(first), state(second, 4.0), (2.0, "gripped", float(is_gripped)), (2.0, "speed", speed)
    ),
    NAMES,
    NAMES,
    st.booleans(),
    st.floats(0.0, 1.0).map(lambda value: round(value, 2)),
)


@given(st.lists(RUNS, min_size=1, max_size=4), st.lists(RUNS, max_size=4))
def test_what_is_learned_holds_inside_and_is_honest_about_outside(inside: list[Log], outside: list[Log]) -> None:
    condition = learned(inside, outside)
    assert condition is not None
    logs = {str(number): one for number, one in enumerate([*inside, *outside])}
    moments = [RunMoment(name, 10.0) for name in logs]
    holds = truths([condition.text], moments, logs, VOCABULARY)[0]
    assert all(holds[: len(inside)])
    wrong = [moment for moment, is_true in zip(moments[len(inside) :], holds[len(inside) :], strict=True) if is_true]
    assert list(condition.wrong) == wrong
