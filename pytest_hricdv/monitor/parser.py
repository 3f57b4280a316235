"""Text of a formula to its syntax tree, and errors of syntax in the user's terms.

Imports lark, so this module is imported only when a formula is parsed.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedToken

from pytest_hricdv.grammar import lark_parser
from pytest_hricdv.monitor.errors import FormulaSource, RequirementError

# Unexpected token -> advice: how other languages write it, or where it is allowed here.
_COMMON_MISTAKES = {
    "and": "a conjunction is written `&`",
    "or": "a disjunction is written `|`",
    "&": "a conjunction is written with one `&`",
    "|": "a disjunction is written with one `|`",
    "=": "equality is written `==`, an implication `->`",
    "implies": "an implication is written `->`",
    "always": "`always` is allowed only at the start and at the top of the response",
    "eventually": "`eventually[a:b](...)` is allowed only at the top of the response",
    "until": "`until` is allowed only at the top of the response: `always(f) until g`",
    "->": "one `->` is allowed, between antecedent and response; elsewhere write `!a | b`",
    "[": "`[hysteresis h]` and `[for d]` follow a comparison, `[a:b]` follows once, historically, eventually or always",
}
_TERMINAL_NAMES = {
    "NAME": "a name",
    "NUMBER": "a number",
    "RELATION": "a comparison",
    "SIGN": "+ or -",
    "FACTOR": "* or /",
    "QUALIFIER": "hysteresis or for",
    "UNARY_OPERATOR": "rise, fall or previously",
    "WINDOWED_OPERATOR": "once or historically",
    "$END": "the end of the formula",
}


@cache
def _grammar() -> Lark:
    # The basic lexer recognizes a keyword at any position; the advice for misplaced keywords needs that.
    return lark_parser(
        Path(__file__).parent / "requirement.lark",
        lexer="basic",
        propagate_positions=True,
        maybe_placeholders=True,
    )


def parse(source: FormulaSource) -> Tree[Token]:
    """The syntax tree of a formula.

    Raises:
        RequirementError: the text is not a formula; the caret marks the first unexpected token.
    """
    try:
        return _grammar().parse(source.formula)
    except UnexpectedToken as unexpected:
        raise _unexpected_token(source, unexpected) from None
    except UnexpectedCharacters as unexpected:
        start = unexpected.pos_in_stream or 0
        character = source.formula[start]
        problem = f"the character {character!r} has no meaning in a formula"
        raise source.error(start, start + 1, problem, _COMMON_MISTAKES.get(character, "")) from None


def _unexpected_token(source: FormulaSource, unexpected: UnexpectedToken) -> RequirementError:
    token: Token = unexpected.token
    expected = _expected_text(unexpected.accepts or unexpected.expected)
    if token.type == "$END":
        end = len(source.formula.rstrip())
        if end == 0:
            return source.error(0, 1, "the formula is empty", "expected always(antecedent -> response)")
        return source.error(end, end + 1, "the formula ends too early", f"expected {expected}")
    start = token.start_pos or 0
    advice = _COMMON_MISTAKES.get(str(token), "")
    if unexpected.expected == {"ALWAYS"} or (str(token) == ")" and "->" in expected):
        advice = "a requirement says when it applies: always(antecedent -> response)"
    lines = f"expected {expected}" + (f"\n{advice}" if advice else "")
    return source.error(start, start + len(token), f"unexpected {str(token)!r}", lines)


def _expected_text(terminals: set[str]) -> str:
    """The terminals that lark expected, as the user writes them."""
    patterns = {terminal.name: terminal.pattern.value for terminal in _grammar().terminals}
    names = sorted({_TERMINAL_NAMES.get(name) or patterns.get(name, name).replace("\\", "") for name in terminals})
    return " or ".join([", ".join(names[:-1]), names[-1]]) if len(names) > 1 else names[0]
