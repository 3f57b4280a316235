"""Random runs, over the case study's vocabulary and a small one, and random formulas over the small one."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from hypothesis import strategies as st

from pytest_hricdv.monitor.formula import AlwaysWithin, Eventually, Formula, Holds, HoldsUntil, Response
from pytest_hricdv.monitor.node import PastFormula
from pytest_hricdv.monitor.past_formula import (
    OPERATORS,
    BooleanName,
    Conjunction,
    Disjunction,
    Historically,
    Negation,
    NumberComparison,
    On,
    Once,
    Since,
    TextComparison,
)
from pytest_hricdv.monitor.terms import (
    ArithmeticTerm,
    Count,
    FloatName,
    Negative,
    NumberTerm,
    Text,
    TextName,
    TimeBetween,
    TimeSince,
)
from tests.monitor.logged_run import TICK_S, Instant, LoggedRun

Signals = Mapping[str, st.SearchStrategy[Any]]
Messages = Mapping[str, st.SearchStrategy[dict[str, Any]]]


@st.composite
def traces(draw: st.DrawFn, signals: Signals, messages: Messages, last: int = 14, busy: int = 0) -> LoggedRun:
    """Runs of up to some more than `last` ticks, at `busy` of which at least something is fed."""
    first = Instant({name: draw(values) for name, values in signals.items()}, _messages(draw, messages))
    instants = {0: first}
    for tick in draw(st.lists(st.integers(1, last), unique=True, min_size=busy).map(sorted)):
        changed = draw(st.lists(st.sampled_from(sorted(signals)), unique=True, max_size=3)) if signals else []
        instants[tick] = Instant({name: draw(signals[name]) for name in changed}, _messages(draw, messages))
    return LoggedRun(instants, draw(st.integers(max(instants), last + 4)))


def _messages(draw: st.DrawFn, messages: Messages) -> tuple[tuple[str, dict[str, Any]], ...]:
    topics = draw(st.lists(st.sampled_from(sorted(messages)), max_size=2)) if messages else []
    return tuple((topic, draw(messages[topic])) for topic in topics)


# --- the case study

truths = st.booleans()
readings = st.fixed_dictionaries(
    dict.fromkeys(("gaze", "pressure", "location"), st.sampled_from([True, True, True, False]))
)
TABLE_SIGNALS: Signals = {
    "leg_held": truths,
    "leg_torn": st.sampled_from([False, False, False, True]),
    "leg_offset": st.sampled_from([0.0, 0.149, 0.15, 0.4]),
    "hand_closing": truths,
    "hand_distance": st.sampled_from([0.0, 0.049, 0.05, 0.052, 0.055, 0.3]),
    "arm_speed": st.sampled_from([0.0, 0.001, 0.002, 0.005, 0.006, 0.1, 0.249, 0.25, 0.3]),
}
reports = st.fixed_dictionaries(
    {"released": st.sampled_from([3.0, 4.0]), "duration_s": st.sampled_from([200.0, 300.0, 301.0]), "on_time": truths}
)
TABLE_MESSAGES: Messages = {
    "reading": readings,
    "request": st.just({}),
    "signal": st.just({}),
    "ready": st.just({}),
    "table_done": reports,
}
table_traces = st.one_of(traces(TABLE_SIGNALS, TABLE_MESSAGES), traces(TABLE_SIGNALS, TABLE_MESSAGES, last=50))


# --- random formulas

SIGNALS: Signals = {
    "p": truths,
    "q": truths,
    "x": st.integers(0, 4).map(float),
    "y": st.integers(0, 4).map(float),
    "s": st.sampled_from("ij"),
}
MESSAGES: Messages = {
    "a": st.just({}),
    "b": st.just({}),
    "m": st.fixed_dictionaries({"ok": truths}),
    "n": st.fixed_dictionaries({"level": st.integers(0, 3).map(float)}),
    "w": st.fixed_dictionaries({"name": st.sampled_from("ij")}),
}


@st.composite
def windows(draw: st.DrawFn, least_end: int = 0) -> tuple[float, float]:
    start = draw(st.integers(0, 4))
    end = draw(st.integers(max(start, least_end), 8))
    return start * TICK_S, end * TICK_S


terms = st.one_of(
    st.sampled_from(["x", "y"]).map(FloatName),
    st.integers(0, 4).map(lambda value: NumberTerm(float(value))),
    st.builds(ArithmeticTerm, st.sampled_from(["+", "-", "*"]), st.just(FloatName("x")), st.just(FloatName("y"))),
    st.just(Negative(FloatName("x"))),
)
comparisons = st.one_of(
    st.builds(
        NumberComparison,
        st.sampled_from(["<", "<=", ">", ">="]),
        st.just(FloatName("x")),
        terms,
        st.sampled_from([0.0, 1.0, 2.0]),
        st.sampled_from([0.0, 0.0, TICK_S, 2 * TICK_S]),
    ),
    st.builds(NumberComparison, st.sampled_from(["==", "!="]), terms, terms),
)
counted = st.sampled_from(
    [On("a"), On("b"), On("m"), BooleanName("p"), Negation(On("a")), Disjunction(On("a"), BooleanName("q"))]
)
since_bounds = st.integers(0, 6).map(lambda ticks: NumberTerm(ticks * TICK_S))
past_comparisons = st.one_of(
    st.builds(
        NumberComparison,
        st.sampled_from(["<", "<=", ">", ">=", "==", "!="]),
        st.builds(lambda operand, window: Count(operand, *window), counted, windows() | st.just((0.0, math.inf))),
        st.integers(0, 3).map(lambda value: NumberTerm(float(value)))
        | st.builds(Count, counted)
        | st.just(FloatName("x")),
        st.just(0.0),
        st.sampled_from([0.0, 0.0, TICK_S, 2 * TICK_S]),
    ),
    st.builds(NumberComparison, st.sampled_from(["<", "<=", ">", ">="]), st.builds(TimeSince, counted), since_bounds),
    st.builds(
        NumberComparison,
        st.sampled_from(["<", "<=", ">", ">=", "==", "!="]),
        st.builds(TimeBetween, counted, counted),
        since_bounds | st.just(FloatName("x")) | st.builds(TimeBetween, counted, counted),
        st.just(0.0),
        st.sampled_from([0.0, 0.0, TICK_S, 2 * TICK_S]),
    ),
    st.builds(NumberComparison, st.sampled_from(["<", "=="]), st.just(FloatName("last(n.level)")), terms),
    st.just(BooleanName("last(m.ok)")),
    st.sampled_from([TextComparison("!=", TextName("w.name"), TextName("last(w.name)"))]),
)
text_comparisons = st.builds(
    TextComparison,
    st.sampled_from(["==", "!="]),
    st.sampled_from(["s", "w.name"]).map(TextName),
    st.sampled_from([Text("i"), Text("j"), TextName("s"), TextName("w.name")]),
    st.sampled_from([0.0, 0.0, 2 * TICK_S]),
)
atoms: st.SearchStrategy[PastFormula] = st.one_of(
    st.sampled_from(["p", "q"]).map(BooleanName),
    st.sampled_from(["a", "b"]).map(On),
    st.just(Conjunction(On("m"), BooleanName("m.ok"))),
    comparisons,
    text_comparisons,
    past_comparisons,
)


def _windowed(kind: type[Once] | type[Historically], operand: PastFormula, window: tuple[float, float]) -> PastFormula:
    return kind(operand, *window)


def larger(inner: st.SearchStrategy[PastFormula]) -> st.SearchStrategy[PastFormula]:
    numbers = st.integers(0, 3).map(lambda value: NumberTerm(float(value)))
    return st.one_of(
        st.builds(NumberComparison, st.sampled_from(["<", ">="]), st.builds(Count, inner), numbers),
        st.builds(NumberComparison, st.sampled_from(["<", "<="]), st.builds(TimeSince, inner), since_bounds),
        st.builds(NumberComparison, st.sampled_from(["<", ">="]), st.builds(TimeBetween, inner, inner), since_bounds),
        st.builds(Negation, inner),
        st.builds(Conjunction, inner, inner),
        st.builds(Disjunction, inner, inner),
        *(st.builds(operator, inner) for operator in OPERATORS.values()),
        st.builds(Since, inner, inner),
        st.builds(_windowed, st.sampled_from([Once, Historically]), inner, windows()),
    )


pasts = st.recursive(atoms, larger, max_leaves=5)
responses: st.SearchStrategy[Response] = st.one_of(
    st.builds(Holds, pasts),
    st.builds(HoldsUntil, pasts, pasts),
    st.builds(lambda condition, window: Eventually(condition, *window), pasts, windows(least_end=1)),
    st.builds(lambda condition, window: AlwaysWithin(condition, *window), pasts, windows(least_end=1)),
)
formulas = st.builds(Formula, pasts, responses)
small_traces = traces(SIGNALS, MESSAGES)
