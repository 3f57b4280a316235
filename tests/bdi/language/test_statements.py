"""The literal of a goal or a belief update may stand in parentheses, as in Jason."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi import BdiSyntaxError
from pytest_hricdv.bdi.language.parser import parse_program
from pytest_hricdv.bdi.language.syntax import Body
from tests.bdi.models import prints_of


def _body(text: str) -> Body:
    return parse_program(f"+!g <- {text}.").plans[0].body


@pytest.mark.parametrize("sign", ["!", "!!", "?", "+", "-", "-+", "++"])
@pytest.mark.parametrize("literal", ["open", "~open", "at(X, 1)[source(self)]", "Any", "~Any[late]"])
def test_a_literal_in_parentheses_is_the_same_statement(sign: str, literal: str) -> None:
    assert _body(f"{sign}({literal})") == _body(f"{sign}(({literal}))") == _body(f"{sign}{literal}")


@pytest.mark.parametrize(
    "text", ["b; -(~open); b", "X = { -(~open); b }", "X = { b; -(~open) }", "if (a) { -(~open) }; b"]
)
def test_a_literal_in_parentheses_stands_wherever_a_statement_does(text: str) -> None:
    assert _body(text) == _body(text.replace("-(~open)", "-~open"))


def test_a_body_as_a_term_may_be_a_single_update_in_parentheses() -> None:
    assert str(_body("X = { -(~open) }")[0]) == "(X = { -~open })"


def test_updates_in_parentheses_change_the_strongly_negated_belief(tmp_path: Path) -> None:
    source = """~open. !go.
    +!go <- -(~open); +(~shut); ?(~shut); !(report).
    +!report : not ~open & ~shut <- .print(done).
    -~open <- .print(deleted).
    """
    assert prints_of(tmp_path, source) == ["deleted", "done"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("+(a & b)", "expected a literal in the parentheses, found (a & b)"),
        ("!(3)", "expected a literal in the parentheses, found 3"),
        ("-(.print(a))", "expected a literal in the parentheses, found .print(a)"),
        ("-(not a)", "expected a literal in the parentheses, found not (a)"),
    ],
)
def test_what_is_no_literal_in_parentheses_is_an_error_with_its_place(text: str, message: str) -> None:
    with pytest.raises(BdiSyntaxError) as caught:
        _body(text)
    assert (caught.value.message, caught.value.line, caught.value.column) == (message, 1, 9)
