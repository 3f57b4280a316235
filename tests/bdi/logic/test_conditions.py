"""Prepared conditions give the first answer of a query."""

from __future__ import annotations

from pathlib import Path

from hypothesis import example, given
from hypothesis import strategies as st

from pytest_hricdv.bdi import Environment
from pytest_hricdv.bdi.actions import StandardActions
from pytest_hricdv.bdi.agent.agent import Agent
from pytest_hricdv.bdi.agent.plan_library import PlanLibrary
from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.parser import parse_literal, parse_plan, parse_program
from pytest_hricdv.bdi.language.syntax import Formula, Rule
from pytest_hricdv.bdi.language.terms import Number, Variable, source
from pytest_hricdv.bdi.logic.beliefs import BeliefBase
from pytest_hricdv.bdi.logic.conditions import ask, condition_of
from pytest_hricdv.bdi.logic.inference import first, solve
from pytest_hricdv.bdi.logic.substitution import Bindings
from pytest_hricdv.bdi.run.system_run import SystemRun
from tests.bdi.models import prints_of

_ATOMS = st.sampled_from(("1", "2", "a", '"s"'))
_TERMS = st.one_of(_ATOMS, st.sampled_from(("X", "Y", "Z", "_", "f(X)", "f(1)", "[X|Y]", "X + 1", "Y * X", "-X")))
_SOURCES = st.sampled_from(("", "", "", "[source(self)]", "[source(b)]", "[source(S)]", "[w(1)]"))
_BELIEFS = st.one_of(
    st.sampled_from(("p", "~p", "q(X)", "r(1, Y)", "q(f(1))", "r(X, X)")),
    st.sampled_from(("p[w(1)]", "p[w(X)]", "q(1)[w(X)]", "q(2)[w(1)]", "r(1, 2)[w(X), source(b)]")),
    st.builds("q({})".format, _ATOMS),
    st.builds("r({}, {})".format, _ATOMS, _ATOMS),
)
_RULES = st.sampled_from(
    ("p :- q(2).", "q(X) :- r(X, 1).", "r(X, Y) :- q(X) & q(Y) & not p.", "q(X)[w(X)] :- r(X, 1).")
)
_LITERALS = st.builds(
    "{}{}".format,
    st.one_of(
        st.sampled_from(("p", "~p", "true", "false")),
        st.builds("q({})".format, _TERMS),
        st.builds("r({}, {})".format, _TERMS, _TERMS),
    ),
    _SOURCES,
)
_COMPARISONS = st.builds(
    "{} {} {}".format, _TERMS, st.sampled_from(("<", "<=", ">", ">=", "==", "\\==", "=", "=")), _TERMS
)
_PARTS = st.one_of(_LITERALS, _LITERALS, st.builds("not {}".format, _LITERALS), _COMPARISONS)
_CONDITIONS = st.recursive(
    _PARTS,
    lambda part: st.one_of(
        st.lists(part, min_size=2, max_size=3).map(" & ".join),
        st.builds("({} | {})".format, part, part),
        st.builds("not ({} & {})".format, part, part),
    ),
    max_leaves=5,
)


def formula(text: str) -> Formula:
    context = parse_plan(f"+!g : {text}.").context
    assert context is not None
    return context


def believer(beliefs: list[str], rules: list[str]) -> Agent:
    base = BeliefBase()
    for rule in parse_program("\n".join(rules), "a.asl").beliefs:
        assert isinstance(rule, Rule)
        base.add_rule(rule)
    for belief in beliefs:
        literal = parse_literal(belief)
        base.add(literal.with_annotations((*literal.annots, source("self"))))
    return Agent("a", SystemRun(Environment(), 0), StandardActions(), base, PlanLibrary(()), [])


_BOUND = st.dictionaries(st.sampled_from((Variable("X"), Variable("Y"))), st.sampled_from((Number(1), Number(2))))
_EVERYTHING = (st.lists(_BELIEFS, max_size=5), st.lists(_RULES, max_size=1), _CONDITIONS, _BOUND)


@example(["q(1)", "q(X)"], [], "q(1)", {})  # the newest belief answers, and binds its own variable
@example(["q(1)", "q(X)", "p"], [], "p & q(1)", {})
@example(["q(1)[w(X)]"], [], "q(Y)[w(1)]", {})  # an annotation with a variable is not to be looked up
@given(*_EVERYTHING)
def test_prepared_condition_has_the_first_answer_of_the_query(
    beliefs: list[str], rules: list[str], condition: str, bound: Bindings
) -> None:
    asked = formula(condition)
    expected: Bindings | str | None
    try:
        expected = next(solve(believer(beliefs, rules), asked, dict(bound)), None)
    except EvaluationError as error:
        expected = str(error)
    answers: list[Bindings | str | None] = []
    agent, bindings = believer(beliefs, rules), dict(bound)
    try:
        decided = condition_of(asked)(agent, bindings)
        holds = ask(agent, asked, bindings) if decided is None else decided
        answers.append(bindings if holds else None)
    except EvaluationError as error:
        answers.append(str(error))
    try:
        answers.append(first(believer(beliefs, rules), asked, dict(bound)))
    except EvaluationError as error:
        answers.append(str(error))
    assert answers == [expected, expected]


def test_asking_for_what_does_not_hold_binds_no_variable_of_a_belief(tmp_path: Path) -> None:
    source = "!go. +!go <- +p(_); if (not p(3)) { .print(no) }; if (p(3) & q) { .print(no) }; ?p(Y); Y = 4; .print(Y)."
    assert prints_of(tmp_path, source) == ["4"]
