"""Conditions that are made ready find what the machine finds that takes formulas as they are."""

from __future__ import annotations

from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st

from pytest_hricdv.bdi import Environment
from pytest_hricdv.bdi.agent import Agent
from pytest_hricdv.bdi.beliefs import BeliefBase
from pytest_hricdv.bdi.conditions import question_of, solutions_of
from pytest_hricdv.bdi.intentions import Frame
from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.formulas import Formula
from pytest_hricdv.bdi.language.parser import parse_literal, parse_plan, parse_program
from pytest_hricdv.bdi.language.syntax import Rule
from pytest_hricdv.bdi.language.terms import Number, Variable
from pytest_hricdv.bdi.library import PlanLibrary
from pytest_hricdv.bdi.logic.inference import first, solve
from pytest_hricdv.bdi.logic.substitution import Bindings
from pytest_hricdv.bdi.scheduler import Run
from tests.bdi.models import prints_of

_ATOMS = st.sampled_from(("1", "2", "a", '"s"'))
_TERMS = st.one_of(_ATOMS, st.sampled_from(("X", "Y", "Z", "_", "f(X)", "f(1)", "[X|Y]", "X + 1", "Y * X", "-X")))
_SOURCES = st.sampled_from(("", "", "", "[source(self)]", "[source(b)]", "[source(S)]", "[w(1)]"))
_BELIEFS = st.one_of(
    st.sampled_from(("p", "~p", "q(X)", "r(1, Y)", "q(f(1))", "r(X, X)")),
    st.builds("q({})".format, _ATOMS),
    st.builds("r({}, {})".format, _ATOMS, _ATOMS),
)
_RULES = st.sampled_from(("p :- q(2).", "q(X) :- r(X, 1).", "r(X, Y) :- q(X) & q(Y) & not p."))
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
        base.add(parse_literal(f"{belief}[source(self)]"))
    return Agent("a", Run(Environment(), 0, None), base, PlanLibrary(()), [])


def frame_with(bindings: Bindings) -> Frame:
    return Frame(parse_plan("+!g."), "+!", parse_literal("g"), dict(bindings))


_BOUND = st.dictionaries(st.sampled_from((Variable("X"), Variable("Y"))), st.sampled_from((Number(1), Number(2))))
_EVERYTHING = (st.lists(_BELIEFS, max_size=5), st.lists(_RULES, max_size=1), _CONDITIONS, _BOUND)


@settings(max_examples=150, deadline=None)
@given(*_EVERYTHING)
def test_question_has_the_first_answer_of_the_machine(
    beliefs: list[str], rules: list[str], condition: str, bound: Bindings
) -> None:
    asked = formula(condition)
    expected: Bindings | str | None
    try:
        expected = first(believer(beliefs, rules), asked, dict(bound))
    except EvaluationError as error:
        expected = str(error)
    frame = frame_with(bound)
    answer: Bindings | str | None
    try:
        answer = frame.unifier if question_of(asked)(believer(beliefs, rules), frame) else None
    except EvaluationError as error:
        answer = str(error)
    assert answer == expected
    if answer is None:
        assert frame.unifier == bound


@settings(max_examples=50, deadline=None)
@given(*_EVERYTHING)
def test_all_solutions_are_those_of_the_machine_in_its_order(
    beliefs: list[str], rules: list[str], condition: str, bound: Bindings
) -> None:
    asked = formula(condition)
    results = []
    for find in (solutions_of(asked), lambda agent, bindings: list(solve(agent, asked, bindings))):
        try:
            results.append(find(believer(beliefs, rules), dict(bound)))
        except EvaluationError as error:
            results.append(str(error))
    assert results[0] == results[1]


def test_asking_for_what_does_not_hold_binds_no_variable_of_a_belief(tmp_path: Path) -> None:
    source = "!go. +!go <- +p(_); if (not p(3)) { .print(no) }; if (p(3) & q) { .print(no) }; ?p(Y); Y = 4; .print(Y)."
    assert prints_of(tmp_path, source) == ["4"]
