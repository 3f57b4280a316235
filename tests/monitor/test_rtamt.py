"""The monitors against rtamt's offline evaluation: the case study's requirements and random formulas, on random runs.

A few runs go with every test session, hundreds with `make slow`.
"""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from pytest_hricdv.monitor import Requirement
from pytest_hricdv.monitor.formula import AlwaysWithin, Eventually, Formula, Holds, HoldsUntil, Response
from pytest_hricdv.monitor.node import PastFormula
from pytest_hricdv.monitor.past_formula import (
    BooleanName,
    Conjunction,
    Disjunction,
    Fall,
    Historically,
    Negation,
    NumberComparison,
    On,
    Once,
    Previously,
    Rise,
    Since,
)
from pytest_hricdv.monitor.terms import ArithmeticTerm, FloatName, NumberTerm
from tests.monitor.logged_run import TICK_S, Instant, LoggedRun
from tests.monitor.logs import run
from tests.monitor.strategies import (
    MESSAGES,
    SIGNALS,
    TABLE_MESSAGES,
    TABLE_SIGNALS,
    Messages,
    Signals,
    traces,
    windows,
)
from tests.monitor.vocabulary import R1, R2, R3, R4, R5

pytest.importorskip("rtamt", reason="the oracle has no release for this Python")

from tests.monitor import rtamt_oracle

QUICK = settings(suppress_health_check=list(HealthCheck))


def agrees(formula: Formula, trace: LoggedRun) -> None:
    assume(trace.last > 0)  # rtamt cannot evaluate a single sample
    verdict = run(formula, trace)
    ours = rtamt_oracle.Counts(verdict.verdict, verdict.triggers, verdict.passes, verdict.failures, verdict.pending)
    assert ours == rtamt_oracle.judge(formula, trace)


# --- the case study: no value lies on a bound, where rtamt's robustness does not say which side it is

OFF_BOUNDS: Signals = {
    **TABLE_SIGNALS,
    "leg_offset": st.sampled_from([0.0, 0.14, 0.16, 0.4]),
    "hand_distance": st.sampled_from([0.0, 0.049, 0.052, 0.056, 0.3]),
    "arm_speed": st.sampled_from([0.0, 0.0005, 0.002, 0.006, 0.1, 0.24, 0.26]),
}
MESSAGES_OFF_BOUNDS: Messages = {
    **TABLE_MESSAGES,
    "table_done": st.fixed_dictionaries(
        {
            "released": st.sampled_from([3.0, 5.0]),
            "duration_s": st.sampled_from([200.0, 301.0]),
            "on_time": st.booleans(),
        }
    ),
}
table_traces = traces(OFF_BOUNDS, MESSAGES_OFF_BOUNDS) | traces(OFF_BOUNDS, MESSAGES_OFF_BOUNDS, last=70, busy=12)
case_study = pytest.mark.parametrize("watched", [R1, R2, R3, R4, R5], ids=lambda watched: watched.id)


@case_study
@given(trace=table_traces)
@QUICK
def test_the_case_study_is_judged_as_by_rtamt(watched: Requirement, trace: LoggedRun) -> None:
    agrees(watched.formula, trace)


# --- random formulas of the part of the language that rtamt has as well

halves = st.integers(0, 4).map(lambda value: NumberTerm(value + 0.5))
sums = st.builds(ArithmeticTerm, st.sampled_from("+-"), st.sampled_from(["x", "y"]).map(FloatName), halves)
bare = st.builds(
    NumberComparison,
    st.sampled_from(["<", "<=", ">", ">="]),
    st.just(FloatName("x")),
    halves | sums,
    st.just(0.0),
    st.sampled_from([0.0, 0.0, TICK_S, 2 * TICK_S]),
)
remembering = st.builds(
    NumberComparison,
    st.sampled_from(["<", "<=", ">", ">="]),
    st.just(FloatName("x")),
    halves,
    st.sampled_from([1.0, 2.0]),
    st.sampled_from([0.0, TICK_S]),
)
truths: st.SearchStrategy[PastFormula] = st.sampled_from(["p", "q"]).map(BooleanName)
messages: st.SearchStrategy[PastFormula] = st.sampled_from(
    [On("a"), On("b"), Conjunction(On("m"), BooleanName("m.ok"))]
)


def windowed(kind: type[Once] | type[Historically], operand: PastFormula, window: tuple[float, float]) -> PastFormula:
    return kind(operand, *window)


def larger(inner: st.SearchStrategy[PastFormula]) -> st.SearchStrategy[PastFormula]:
    return st.one_of(
        st.builds(Negation, inner),
        st.builds(Conjunction, inner, inner),
        st.builds(Disjunction, inner, inner),
        st.builds(Since, inner, inner),
        st.builds(Once, inner),
        st.builds(Historically, inner),
        st.builds(windowed, st.sampled_from([Once, Historically]), inner, windows()),
    )


# What holds for a length of time, and what is true at instants only. The first instant is left out for edges and
# `previously`, about which the two do not agree: whether a signal that starts true rises there.
kept = st.recursive(truths | bare | messages.map(Once), larger, max_leaves=4)
lasting = st.recursive(truths | bare | remembering | messages.map(Once), larger, max_leaves=4)
settled = BooleanName("settled")
edges = st.builds(lambda kind, f: Conjunction(settled, kind(f)), st.sampled_from([Rise, Fall]), lasting)
events = st.one_of(
    messages,
    edges,
    st.builds(Conjunction, messages | edges, lasting),
    st.builds(lambda event, f: Conjunction(Conjunction(settled, event), Previously(f)), messages | edges, lasting),
    st.builds(Disjunction, messages, edges),
)
absences = events.map(Negation)
longer = windows(least_end=1)
responses: st.SearchStrategy[Response] = st.one_of(
    st.builds(Holds, kept),
    st.builds(lambda f, window: Eventually(f, *window), kept | events, longer),
    st.builds(lambda f, window: AlwaysWithin(f, *window), kept | absences, longer),
    st.builds(HoldsUntil, kept | absences, lasting | events),
)
at_instants = st.builds(Holds, kept | events | absences)
formulas = st.builds(Formula, lasting, responses) | st.builds(Formula, events, responses | at_instants)


@st.composite
def settled_traces(draw: st.DrawFn) -> LoggedRun:
    trace: LoggedRun = draw(traces(SIGNALS, MESSAGES, busy=draw(st.sampled_from([0, 6]))))
    instants = dict(trace.instants)
    for tick, is_settled in ((0, False), (1, True)):
        instant = instants.get(tick, Instant())
        instants[tick] = Instant({**instant.signals, "settled": is_settled}, instant.messages)
    return LoggedRun(instants, max(trace.last, 1))


@pytest.mark.slow
@given(formula=formulas, trace=settled_traces())
@QUICK
def test_a_random_formula_is_judged_as_by_rtamt(formula: Formula, trace: LoggedRun) -> None:
    agrees(formula, trace)
