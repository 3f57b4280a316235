"""An operator that the grammar knows and the parser does not is an internal error at once, not another operator."""

from __future__ import annotations

from pathlib import Path

import pytest
from lark import Lark

from pytest_hricdv.monitor import parse_formula, syntax_tree
from pytest_hricdv.monitor.term_parser import UnknownOperatorError
from tests.monitor.vocabulary import SMALL

GRAMMAR = (Path(syntax_tree.__file__).parent / "requirement.lark").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("old", "new", "text", "says"),
    [
        ("(rise|fall", "(next|rise|fall", "always(next(p) -> q)", "operator 'next'.*'operator'"),
        ("(once|", "(mostly|once|", "always(mostly[0:1](p) -> q)", "operator 'mostly'.*'operator'"),
        ('COUNT [window] "(" expr ")"', 'COUNT "(" expr ")"  -> size\n     | COUNT window "(" expr ")"',
         "always(count(p) < 2 -> q)", "'size'"),
        ('SIGN: "+" | "-"', 'SIGN: "+" | "-" | "~"', "always(x < ~y -> q)", "operator '~'.*'signed'"),
        ('FACTOR: "*" | "/"', 'FACTOR: "*" | "/" | "%%"', "always(x %% y < 1 -> q)", "operator '%%'.*'arithmetic'"),
        ("(hysteresis|for)", "(hysteresis|for|every)", "always(x < 1 [every 2] -> q)", "operator 'every'.*'qualifier'"),
        ('| expr                                  -> holds', '| "never" expr -> never\n         | expr -> holds',
         "always(p -> never q)", "'never'"),
    ],
)  # fmt: skip
def test_an_unknown_operator_names_its_rule(
    old: str, new: str, text: str, says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert old in GRAMMAR
    starts = ["formula", "condition", "definition", "pattern"]
    grammar = Lark(
        GRAMMAR.replace(old, new), parser="lalr", lexer="basic", propagate_positions=True, maybe_placeholders=True,
        start=starts,
    )  # fmt: skip
    monkeypatch.setattr(syntax_tree, "_grammar", lambda: grammar)
    with pytest.raises(UnknownOperatorError, match=says):
        parse_formula(text, SMALL)
