"""Many triggers that are open at a time: the monitors compared with the reference, which goes through all of them."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pytest_hricdv.monitor import MonitorSet
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
from tests.monitor.logs import run, summary
from tests.monitor.reference import ReferenceEvaluator
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
    responses,
)
overlapping_formulas = st.builds(Formula, frequent | conditions, overlapping)


def agree(formula: Formula, trace: LoggedRun, shows: tuple[str, ...] = ()) -> None:
    """Monitors and the reference, which looks at each trigger for itself, say the same."""
    assert summary(run(formula, trace, shows=shows)) == ReferenceEvaluator(trace).judge(formula, shows)


@given(formula=overlapping_formulas, trace=busy_traces)
@RUNS
def test_overlapping_windows_are_judged_as_one_by_one(formula: Formula, trace: LoggedRun) -> None:
    agree(formula, trace)


@given(formula=formulas, trace=busy_traces, shows=st.sampled_from([(), ("x",), ("x", "y")]))
@RUNS
def test_any_formula_is_judged_as_one_by_one(formula: Formula, trace: LoggedRun, shows: tuple[str, ...]) -> None:
    agree(formula, trace, shows)


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
