"""Terms are values that print as AgentSpeak text and parse back."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.bdi import BdiError, BdiSyntaxError, Environment, ListTerm, Number, String, Structure, Term, Variable
from pytest_hricdv.bdi.language.parser import parse_literal, parse_program, parse_term
from pytest_hricdv.bdi.language.terms import Arithmetic, sort_terms
from pytest_hricdv.bdi.logic.substitution import substitute_only
from pytest_hricdv.bdi.logic.unify import unify

KEYWORDS = {"not", "div", "mod", "if", "else", "elif", "while", "for", "include"}
names = st.from_regex(r"[a-z][a-zA-Z0-9_]{0,5}", fullmatch=True).filter(lambda name: name not in KEYWORDS)
variables = st.from_regex(r"[A-Z][a-zA-Z0-9_]{0,3}", fullmatch=True).map(Variable)
numbers = st.floats(allow_nan=False, allow_infinity=False).map(Number) | st.integers(-999, 999).map(Number)
strings = st.text(st.characters(codec="utf-8"), max_size=8).map(String)
leaves: st.SearchStrategy[Term] = numbers | strings | variables | names.map(Structure)


def _compound(parts: st.SearchStrategy[Term]) -> st.SearchStrategy[Term]:
    several = st.lists(parts, max_size=3).map(tuple)
    structures = st.builds(
        lambda functor, args, annots, negated: Structure(functor, args, sort_terms(annots), negated),
        names,
        several,
        several,
        st.booleans(),
    )
    lists = st.builds(ListTerm, several) | st.builds(ListTerm, several.filter(bool), variables)
    sums = st.builds(
        lambda operator, left, right: Arithmetic(operator, (left, right)),
        st.sampled_from(["+", "-", "*", "/", "div", "mod", "**"]),
        numbers | variables,
        numbers | variables,
    )
    return structures | lists | sums


terms = st.recursive(leaves, _compound, max_leaves=12)


@given(terms)
def test_a_term_printed_parses_back_to_an_equal_term(term: Term) -> None:
    again = parse_term(str(term))
    assert again == term
    assert hash(again) == hash(term)
    assert str(again) == str(term)


@given(terms)
def test_a_term_can_be_copied_and_pickled(term: Term) -> None:
    for other in (copy.copy(term), copy.deepcopy(term), pickle.loads(pickle.dumps(term))):
        assert other == term
        assert (str(other), hash(other)) == (str(term), hash(term))


@given(terms, terms)
def test_what_was_unified_is_equal_under_the_bindings(left: Term, right: Term) -> None:
    plain = [term for term in (left, right) if "[" not in str(term) and not isinstance(term, Arithmetic)]
    bindings: dict[Variable, Term] = {}
    if len(plain) == 2 and unify(left, right, bindings, []):
        for _ in range(len(bindings) + 1):
            left, right = substitute_only(left, bindings), substitute_only(right, bindings)
        assert left == right


@given(st.text(max_size=60) | st.text('+-!?pX(,)[]|.<-:&~@"{};= 1\n', max_size=60))
def test_parser_gives_a_program_or_a_located_error(text: str) -> None:
    _parse_or_locate(text)


TOKENS = [
    *("+!g", ":", "p", "<-", "q", ";", ".", "(", ")", "X", "=", "1", "{", "}", "if", "while"),
    *("not", "&", "|", "-b", "!!h", "?t", "@l", "[", "]", ",", ".print", ":-", "~"),
]


@given(st.lists(st.sampled_from(TOKENS)))
def test_parser_survives_any_order_of_real_tokens(tokens: list[str]) -> None:
    _parse_or_locate(" ".join(tokens))


def _parse_or_locate(text: str) -> None:
    raised: BdiSyntaxError | None = None
    try:
        parse_program(text, "fuzz.asl")
    except BdiSyntaxError as error:
        raised = error
    if raised is not None:
        assert str(raised).startswith(f"fuzz.asl:{raised.line}:{raised.column}: ")
        assert 1 <= raised.line <= text.count("\n") + 1
        assert raised.column >= 1


def test_a_percept_must_be_a_literal() -> None:
    with pytest.raises(BdiError, match="expected a literal, found 3"):
        parse_literal("3")


@pytest.mark.parametrize(
    ("percepts", "said"),
    [
        ("q(1)", r"the percepts of a must be a list, even if there is only one: \['q\(1\)'\]"),
        (Structure("q"), r"the percepts of a must be a list"),
        ([3], r"a percept is a string or a structure, not 3 \(int\)"),
        (["q(X)"], r"a percept has no variables: q\(X\)"),
    ],
)
def test_what_cannot_be_perceived_is_refused(percepts: Any, said: str) -> None:
    with pytest.raises(BdiError, match=said):
        Environment().show("a", percepts)
