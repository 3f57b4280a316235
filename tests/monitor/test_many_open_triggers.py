"""Many triggers that are open at a time: the monitors compared with slow ones, which go through all of them."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pytest_hricdv.monitor import MonitorSet, Requirement, Verdict
from pytest_hricdv.monitor.formula import AlwaysWithin, Eventually, Formula, Response
from pytest_hricdv.monitor.node import PastFormula
from pytest_hricdv.monitor.past_formula import (
    BooleanName,
    Disjunction,
    Historically,
    Negation,
    NumberComparison,
    On,
    Once,
    Rise,
)
from pytest_hricdv.monitor.terms import Count, FloatName, NumberTerm
from tests.monitor.logged_run import TICK_S, Instant, LoggedRun, Value
from tests.monitor.slow_monitor import SlowMonitorSet
from tests.monitor.strategies import formulas, larger, pasts, responses
from tests.monitor.vocabulary import requirement
from tests.steps import steps_of

RUNS = settings(suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])

# --- runs in which many windows overlap: dozens of events, windows from shorter than their distance to the whole run

VALUES: dict[str, Sequence[Value]] = {"p": (False, True), "q": (False, True), "x": range(5), "y": range(5), "s": "ij"}
FIELDS: dict[str, Mapping[str, Sequence[Value]]] = {
    "a": {},
    "b": {},
    "m": {"ok": (False, True)},
    "n": {"level": range(4)},
    "w": {"name": "ij"},
}


def busy_trace(seed: int) -> LoggedRun:
    """A run with up to 100 instants, made from a number: drawn one by one, so long runs would take too long."""
    stream = random.Random(seed)

    def value(values: Sequence[Value]) -> Value:
        chosen = stream.choice(values)
        return chosen if isinstance(chosen, bool | str) else float(chosen)

    instants = {0: Instant({name: value(values) for name, values in VALUES.items()})}
    last = stream.randint(10, 100)
    busy = stream.choice([0.3, 0.8, 1.0])
    for tick in range(1, last):
        if stream.random() < busy:
            names = stream.sample(sorted(VALUES), stream.randint(0, 2))
            topics = stream.choices(sorted(FIELDS), [4, 2, 1, 1, 1], k=stream.randint(0, 2))
            messages = [(topic, {name: value(values) for name, values in FIELDS[topic].items()}) for topic in topics]
            instants[tick] = Instant({name: value(VALUES[name]) for name in names}, tuple(messages))
    return LoggedRun(instants, last + stream.randint(0, 4))


busy_traces = st.integers(0, 2**32).map(busy_trace)
wide = st.tuples(st.integers(0, 30), st.integers(0, 40)).map(
    lambda ticks: (min(ticks) * TICK_S, max(*ticks, 1) * TICK_S)
)


def _over(kind: type[Once] | type[Historically], operand: PastFormula, window: tuple[float, float]) -> PastFormula:
    return kind(operand, *window)


frequent: st.SearchStrategy[PastFormula] = st.sampled_from(
    [On("a"), On("m"), Disjunction(On("a"), On("b")), BooleanName("p"), Rise(BooleanName("q")), Negation(On("a"))]
)
x_is_small: PastFormula = NumberComparison("<", FloatName("x"), NumberTerm(3.0))
remembered = st.builds(_over, st.sampled_from([Once, Historically]), frequent | st.just(x_is_small), wide)
counted = st.builds(
    lambda operand, window, least: NumberComparison(">=", Count(operand, *window), NumberTerm(float(least))),
    frequent,
    wide,
    st.integers(1, 9),
)
conditions = (
    frequent | remembered | counted | st.just(x_is_small) | pasts | st.recursive(remembered, larger, max_leaves=3)
)
overlapping: st.SearchStrategy[Response] = st.one_of(
    st.builds(lambda condition, window: Eventually(condition, *window), conditions, wide),
    st.builds(lambda condition, window: AlwaysWithin(condition, *window), conditions, wide),
    st.builds(lambda condition, start: Eventually(condition, start * TICK_S, math.inf), conditions, st.integers(0, 20)),
    st.builds(
        lambda condition, start: AlwaysWithin(condition, start * TICK_S, math.inf), conditions, st.integers(0, 20)
    ),
    responses,
)
overlapping_formulas = st.builds(Formula, frequent | conditions, overlapping)


def fed(monitors: MonitorSet, trace: LoggedRun) -> tuple[list[object], tuple[Verdict, ...]]:
    """What the monitors say while the run goes on, and the verdicts."""
    said: list[object] = []
    for tick, instant in sorted(trace.instants.items()):
        monitors.advance(tick * TICK_S)
        said.append((monitors.next_deadline_s(), monitors.so_far()))
        for name, value in instant.signals.items():
            monitors.signal(tick * TICK_S, name, value)
        for topic, fields in instant.messages:
            monitors.message(tick * TICK_S, topic, fields)
    return said, monitors.finish(trace.last * TICK_S)


def agree(formula: Formula, trace: LoggedRun, shows: tuple[str, ...] = ()) -> tuple[Verdict, ...]:
    """Both say the same, during the run and at its end: counts, times, values, margins, triggers."""
    watched = Requirement("R", "", "", "", formula, shows)
    (said, verdicts), slow = fed(MonitorSet([watched]), trace), fed(SlowMonitorSet([watched]), trace)
    assert said == slow[0]
    assert verdicts == slow[1]
    return verdicts


@given(formula=overlapping_formulas, trace=busy_traces)
@RUNS
def test_overlapping_windows_are_judged_as_one_by_one(formula: Formula, trace: LoggedRun) -> None:
    agree(formula, trace)


@given(formula=formulas, trace=busy_traces, shows=st.sampled_from([(), ("x",), ("x", "y")]))
@RUNS
def test_any_formula_is_judged_as_one_by_one(formula: Formula, trace: LoggedRun, shows: tuple[str, ...]) -> None:
    agree(formula, trace, shows)


# --- cases of the kind, with times that are no whole ticks

CASES = [
    "always(on(a) -> eventually[0:60](p))",
    "always(on(a) -> eventually[0:0.5](p))",
    "always(on(a) -> eventually[2.5:7](on(b)))",
    "always(on(a) -> eventually[5:5](p))",
    "always(on(a) -> always[0:8](x < 4))",
    "always(on(a) -> always[3:8](x < 4))",
    "always(on(a) -> always[3:3](x < 4 | p))",
    "always(on(a) -> always(x < 4) until on(b))",
    "always(on(a) -> always(!on(b)) until p)",
    "always(on(a) -> once[0:5](on(b)))",
    "always(on(a) -> once[2:9](on(b)))",
    "always(on(a) -> once[4:4](p))",
    "always(on(a) -> historically[0:3](x < 4))",
    "always(on(a) -> historically[1:3](!on(b)))",
    "always(rise(once[1:2](on(a))) -> eventually[0:4](historically[0:1](p)))",
    "always(on(a) -> (x < 4) since on(b))",
    "always((once[0:1](p) since on(b)) & on(a) -> eventually[0:3](on(b) | x > 3))",
    "always(count[0:4](on(a)) > 5 -> eventually[0:3](count[1:6](on(b)) < 9))",
    "always(on(a) | on(b) -> eventually[1:20](time_since(p) < 3 & x > 2 [for 0.5]))",
    "always(on(a) -> always[0.1:0.2](x > 0 [hysteresis 1] & !p | q))",
    "always(!on(a) -> eventually[0:6](on(a)))",
    "always(p -> eventually[0:2](on(a)))",
]


@pytest.mark.parametrize("text", CASES)
def test_a_busy_run_is_judged_as_one_by_one(text: str) -> None:
    stream = random.Random(text)
    watched = requirement(text)
    fast, slow = MonitorSet([watched]), SlowMonitorSet([watched])
    time_s = 0.0
    for monitors in (fast, slow):
        for name, first in {"p": False, "q": True, "x": 1.0}.items():
            monitors.signal(0.0, name, first)
    for _ in range(1200):
        # 0 s: several updates at one instant. Times of an exact decimal meet the ends of windows.
        time_s = round(time_s + stream.choice([0.0, 0.02, 0.02, 0.1, 0.5]), 2)
        updates: list[tuple[str, float | None]] = [
            ("a", None),
            ("a", None),
            ("a", None),
            ("b", None),
            ("p", stream.random() < 0.3),
            ("x", float(stream.randint(0, 4))),
        ]
        name, value = stream.choice(updates)
        for monitors in (fast, slow):
            if value is None:
                monitors.message(time_s, name, {})
            else:
                monitors.signal(time_s, name, value)
        assert fast.next_deadline_s() == slow.next_deadline_s()
        assert fast.so_far() == slow.so_far()
    [verdict] = fast.finish(time_s + 2.5)
    assert (verdict,) == slow.finish(time_s + 2.5)
    assert verdict.triggers > 5


# --- what an event costs

STEPS_OF = [
    "always(on(a) -> eventually[0:60](p))",
    "always(on(a) -> eventually[30:60](p))",
    "always(on(a) -> always[0:60](x < 4))",
    "always(on(a) -> always[30:60](x < 4))",
    "always(on(a) -> always(x < 4) until p)",
    "always(on(a) -> once[0:60](on(b)))",
    "always(on(a) -> once[30:30.001](on(a)))",
    "always(on(a) -> historically[30:30.001](!on(a)))",
    "always(on(a) -> x < 4 since on(b))",
    "always(on(a) & count[30:60](on(a)) >= 0 -> x < 4)",
    "always(once[20:20.001](on(a)) & x < 4 -> eventually[0:60](historically[20:20.001](!on(a))))",
]


@pytest.mark.parametrize("text", STEPS_OF)
def test_an_event_takes_as_many_steps_after_many_as_after_few(text: str) -> None:
    monitors = MonitorSet([requirement(text)])
    monitors.signal(0.0, "p", False)
    monitors.signal(0.0, "x", 1.0)
    steps = [steps_of(lambda time_s=number / 50: monitors.message(time_s, "a", {})) for number in range(1, 1400)]  # type: ignore[misc]
    # With the 1,300th event a window or two may begin and end, each of which is judged as an event is. Going through
    # all that is open would take ten times the steps of the 130th.
    assert max(steps[1200:]) <= 3 * max(steps[100:130])
