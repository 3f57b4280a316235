"""Expressions without variables in initial beliefs and goals have their values from the start."""

from __future__ import annotations

import pytest

from pytest_hricdv.bdi import BdiSyntaxError
from pytest_hricdv.bdi.language.parser import parse_program, parse_term
from pytest_hricdv.bdi.language.syntax_tree import with_constants_evaluated


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("p(1 + 2)", "p(3)"),
        ("p(2 ** 3 - 1, [4 / 2, q(7 div 2)])[n(7 mod 4)]", "p(7,[2,q(3)])[n(3)]"),
        ("p(1 + 2, X + 1)", "p(3,(X+1))"),
        ("p(X + (1 + 2))", "p((X+3))"),
        ("p(X)", "p(X)"),
        ("p(math.abs(1 - 2) + 1)", "p((math.abs((1-2))+1))"),
        ("1 / 0", "Infinity"),
        ("0 / 0", "NaN"),
        ("-2 ** 2", "4"),  # as in Jason, a sign binds tighter than a power
    ],
)
def test_expressions_without_variables_are_evaluated(text: str, value: str) -> None:
    assert str(with_constants_evaluated(parse_term(text))) == value


@pytest.mark.parametrize(
    ("text", "message", "column"),
    [
        ("size(a + 1).", "expected a number or a variable in arithmetic, found a", 6),
        ("!reach(1 div 0).", "(1 div 0) has no value", 1),
    ],
)
def test_an_expression_without_a_value_is_an_error_with_its_place(text: str, message: str, column: int) -> None:
    with pytest.raises(BdiSyntaxError) as caught:
        parse_program(text)
    assert (caught.value.message, caught.value.line, caught.value.column) == (message, 1, column)
