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
from pytest_hricdv.bdi.language.terms import Arithmetic, sort_terms, term_order
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


@given(st.lists(terms, max_size=6))
def test_any_terms_have_an_order(several: list[Term]) -> None:
    keys = [term_order(term) for term in several]
    assert all(left <= right or right <= left for left in keys for right in keys)


@given(terms)
def test_a_term_unifies_with_itself_without_binding(term: Term) -> None:
    bindings: dict[Variable, Term] = {}
    assert unify(term, term, bindings, [])
    assert bindings == {}


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


def test_term_order_is_numbers_strings_lists_literals_negated_literals_variables() -> None:
    text = '[4,"x",[],[a],[c],[a,b],[b,c],a,b,a(3),a(10)[5],a(10)[30],b(3),b(4),a(d,e),a(e,f),b(1,1),~a(3),A,C]'
    ordered = parse_term(text)
    assert isinstance(ordered, ListTerm)
    assert [str(term) for term in sorted(set(ordered.items), key=term_order)] == [str(term) for term in ordered.items]


def test_number_is_printed_without_fraction_when_it_has_none() -> None:
    assert [str(Number(value)) for value in (3.0, -0.5, 1e10, 1e-5, 12345678.25, 2.0**63, 2.0**64)] == [
        "3",
        "-0.5",
        "10000000000",
        "1.0E-5",
        "1.234567825E7",
        "9223372036854775807",
        "1.8446744073709552E19",
    ]


def test_structure_shows_its_functor_and_arguments() -> None:
    action = parse_literal("set_param(gaze, 1)")
    assert action.functor == "set_param"
    assert [str(arg) for arg in action.args] == ["gaze", "1"]
    assert action.args[1] == Number(1)
    assert str(action) == "set_param(gaze,1)"


def test_annotations_are_kept_in_term_order_and_once() -> None:
    assert str(parse_literal("p[source(self),b,a,b]")) == "p[a,b,source(self)]"


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


def test_long_flat_programs_are_read() -> None:
    program = parse_program("".join(f"p({i}). +!g({i}) : p(X) & X > {i} <- .print(X); q.\n" for i in range(300)))
    assert len(program.plans) == 300


def test_a_percept_must_be_a_literal() -> None:
    with pytest.raises(BdiError, match="expected a literal, found 3"):
        parse_literal("3")


@pytest.mark.parametrize(
    ("percepts", "said"),
    [
        ("q(1)", r"the percepts of a must be a list, even if there is only one: \['q\(1\)'\]"),
        (Structure("q"), r"the percepts of a must be a list"),
        ([3], r"a percept is a text or a structure, not 3 \(int\)"),
        (["q(X)"], r"a percept has no variables: q\(X\)"),
    ],
)
def test_what_cannot_be_perceived_is_refused(percepts: Any, said: str) -> None:
    with pytest.raises(BdiError, match=said):
        Environment().show("a", percepts)
