"""A query with annotations has every answer of Jason's, in its order: a belief without them hides no other belief."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import permutations
from pathlib import Path

import pytest
from hypothesis import event, example, given
from hypothesis import strategies as st

from pytest_hricdv.bdi.language.parser import parse_literal, parse_term
from pytest_hricdv.bdi.language.terms import Variable
from pytest_hricdv.bdi.logic.conditions import ask, condition_of
from pytest_hricdv.bdi.logic.inference import first, solve
from pytest_hricdv.bdi.logic.substitution import Bindings
from tests.bdi.logic.test_conditions import believer, formula
from tests.bdi.models import prints_of

BELIEFS = "c(1)[k]. c(2)[m]. c(3)[k]. ready(1)[source(a)]. ready(2). ready(3)[source(b)]. "
KINDS = {
    "findall": ("+!g <- .findall(X, c(X)[k], L); .print(L); .findall(X, c(X)[m], M); .print(M).", ["[1,3]", "[2]"]),
    "context": ("+!g : c(X)[m] & c(Y)[k] & Y > X <- .print(X, Y). +!g <- .print(none).", ["23"]),
    "test goal": ("+!g <- ?c(X)[m]; .print(X); ?(c(Y)[k] & Y > 1); .print(Y).", ["2", "3"]),
    "loop": ("+!g <- for (c(X)[k]) { .print(X) }; for (c(X)[m]) { .print(X) }.", ["1", "3", "2"]),
    "count": ("+!g <- .count(c(_)[k], N); .print(N); .print(.count(c(X)[m])).", ["2", "1"]),
    "removal": (
        "+!g <- .abolish(c(X)[m]); -c(Y)[k]; -ready(Z)[source(b)]; .findall(N, c(N), L); .findall(N, ready(N), M); "
        ".print(L, M).",
        ["[3][1,2]"],
    ),
    "source": ("+!g : ready(X)[source(b)] & not ready(X)[source(self)] <- .print(X). +!g <- .print(none).", ["3"]),
    "rule": ("r(X) :- c(X)[m]. +!g <- .findall(X, r(X), L); .print(L).", ["[2]"]),
    "rule without annotations": ("s(X) :- c(X). s(4)[k]. +!g <- ?s(X)[k]; .print(X).", ["4"]),
}
"""Ways to ask, as plans of an agent with :data:`BELIEFS`, and what is printed."""


@pytest.mark.parametrize(("plans", "expected"), KINDS.values(), ids=KINDS.keys())
def test_belief_without_the_annotations_hides_no_answer(plans: str, expected: list[str], tmp_path: Path) -> None:
    assert prints_of(tmp_path, f"{BELIEFS}!g. {plans}") == expected


# --- against a slow solver


Values = dict[str, str]
"""The values of variables, as text; a variable without one is not bound."""


@dataclass(frozen=True)
class Literal:
    """A literal ``functor(args)[annots|tail]``; in a belief it has no variables.

    An annotation is ``(functor, argument)``, with an empty functor for an atom or a variable.
    """

    functor: str
    args: tuple[str, ...]
    annots: tuple[tuple[str, str], ...] = ()
    tail: str = ""
    negated: bool = False

    def __str__(self) -> str:
        annots = ",".join(map(_annotation_text, self.annots)) + (f"|{self.tail}" if self.tail else "")
        args = f"({','.join(self.args)})" if self.args else ""
        return f"{'not ' if self.negated else ''}{self.functor}{args}{f'[{annots}]' if annots else ''}"


def _annotation_text(annot: tuple[str, str]) -> str:
    return f"{annot[0]}({annot[1]})" if annot[0] else annot[1]


def _annotation_order(annot: tuple[str, str]) -> tuple[bool, bool, str, bool, str]:
    """Jason's order of terms: atoms, then structures by functor and argument, and variables after what has a value."""
    functor, argument = annot
    is_variable = argument[0].isupper()
    return is_variable and not functor, bool(functor), functor, is_variable, argument


def _matched(pattern: str, value: str, values: Values) -> Values | None:
    """The values with those by which a pattern is a value; None if it cannot be."""
    if not pattern[0].isupper():
        return values if pattern == value else None
    return values if values.get(pattern) == value else None if pattern in values else {**values, pattern: value}


def _matched_annotation(pattern: tuple[str, str], annot: tuple[str, str], values: Values) -> Values | None:
    if pattern[0] != annot[0]:
        # A variable stands for a whole annotation, too.
        return (
            None if pattern[0] or not pattern[1][0].isupper() else _matched(pattern[1], _annotation_text(annot), values)
        )
    return _matched(pattern[1], annot[1], values)


def _ways(query: Literal, belief: Literal, values: Values) -> Iterator[Values]:
    """The values of each way in which a belief answers a query: each annotation asked for is another one of its."""
    if (query.functor, len(query.args)) != (belief.functor, len(belief.args)):
        return
    for chosen in permutations(belief.annots, len(query.annots)):
        way: Values | None = values
        for pattern, value in zip(query.args, belief.args, strict=True):
            way = None if way is None else _matched(pattern, value, way)
        for annotation, annot in zip(query.annots, chosen, strict=True):
            way = None if way is None else _matched_annotation(annotation, annot, way)
        if way is not None and query.tail:
            rest = ",".join(_annotation_text(annot) for annot in belief.annots if annot not in chosen)
            way = _matched(query.tail, f"[{rest}]", way)
        if way is not None:
            yield way


def _answers(queries: tuple[Literal, ...], beliefs: list[Literal], values: Values) -> Iterator[Values]:
    """All answers of a conjunction, the newest beliefs first."""
    if not queries:
        yield values
        return
    query, rest = queries[0], queries[1:]
    ways = (way for belief in reversed(beliefs) for way in _ways(query, belief, values))
    if query.negated:
        if not any(True for _ in ways):
            yield from _answers(rest, beliefs, values)
        return
    for way in ways:
        yield from _answers(rest, beliefs, way)


_CONSTANTS = st.sampled_from(("1", "2", "a"))
_VARIABLES = st.sampled_from(("X", "Y", "Z"))
_ASKED = st.one_of(_CONSTANTS, _VARIABLES, _VARIABLES)
_HELD_ANNOTATIONS = st.one_of(
    st.sampled_from((("", "k"), ("", "m"))),
    st.tuples(st.just("w"), _CONSTANTS),
    st.tuples(st.just("source"), st.sampled_from(("a", "b"))),
)
_ASKED_ANNOTATIONS = st.one_of(
    _HELD_ANNOTATIONS,
    st.tuples(st.just(""), _VARIABLES),
    st.tuples(st.sampled_from(("w", "source")), _ASKED),
)
_FUNCTORS = st.sampled_from((("p", 0), ("q", 1), ("q", 1), ("r", 2)))


@st.composite
def _belief(draw: st.DrawFn) -> Literal:
    functor, arity = draw(_FUNCTORS)
    args = tuple(draw(_CONSTANTS) for _ in range(arity))
    return Literal(functor, args, tuple(draw(st.lists(_HELD_ANNOTATIONS, max_size=3))))


@st.composite
def _query(draw: st.DrawFn) -> Literal:
    functor, arity = draw(_FUNCTORS)
    args = tuple(draw(_ASKED) for _ in range(arity))
    annots = draw(st.lists(_ASKED_ANNOTATIONS, max_size=2, unique=True))
    tail = draw(st.sampled_from(("", "", "", "T"))) if annots else ""
    # The parser puts annotations into this order: it decides in which order the ways come.
    return Literal(functor, args, tuple(sorted(annots, key=_annotation_order)), tail, draw(st.integers(0, 3)) == 0)


def _believed(beliefs: list[Literal]) -> list[Literal]:
    """What is held after adding beliefs, each by ``self``: annotations come to the belief already held, in order."""
    held: dict[tuple[str, tuple[str, ...]], set[tuple[str, str]]] = {}
    for belief in beliefs:
        held.setdefault((belief.functor, belief.args), {("source", "self")}).update(belief.annots)
    return [Literal(*key, tuple(sorted(annots, key=_annotation_order))) for key, annots in held.items()]


def _as_text(bindings: Bindings | None) -> Values | None:
    return None if bindings is None else {str(variable): str(value) for variable, value in bindings.items()}


_C = [Literal("q", ("1",), (("", "k"),)), Literal("q", ("2",), (("", "m"),)), Literal("q", ("a",), (("", "k"),))]


@example(_C, [Literal("q", ("X",), (("", "m"),))], {})
@example(_C, [Literal("q", ("X",), (("", "k"),)), Literal("q", ("Y",), (("", "m"),))], {})
@given(
    st.lists(_belief(), max_size=6),
    st.lists(_query(), min_size=1, max_size=3),
    st.dictionaries(_VARIABLES, st.sampled_from(("1", "2")), max_size=1),
)
def test_annotated_queries_have_the_answers_of_a_slow_solver(
    beliefs: list[Literal], queries: list[Literal], bound: Values
) -> None:
    expected = list(_answers(tuple(queries), _believed(beliefs), bound))
    event(f"{min(len(expected), 5)} answers")
    agent = believer([], [])
    for belief in beliefs:
        agent.beliefs.add(parse_literal(str(replace(belief, annots=(*belief.annots, ("source", "self"))))))
    asked = formula(" & ".join(map(str, queries)))
    before = {Variable(name): parse_term(value) for name, value in bound.items()}
    assert [_as_text(answer) for answer in solve(agent, asked, before)] == expected
    expected_first = expected[0] if expected else None
    assert _as_text(first(agent, asked, before)) == expected_first
    bindings = dict(before)
    decided = condition_of(asked)(agent, bindings)
    holds = ask(agent, asked, bindings) if decided is None else decided
    assert (_as_text(bindings) if holds else None) == expected_first
