"""`syntax_tree` parses the text of a formula; its errors say what was expected and how to write it here.

`FormulaParser` makes formulas of the trees. The module imports lark, so it is imported only when a formula is parsed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Literal

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedToken

from pytest_hricdv._base.grammar import lark_parser
from pytest_hricdv._base.message import quote
from pytest_hricdv.monitor.requirement import FormulaSource, RequirementError

MAX_LENGTH = 100_000
"""Longest text of a formula (characters), a hundred times that of a long formula. It takes a second to parse (0.12 s
for 10,000 characters)."""

MAX_NODES = 10_000
"""Most operators and operands of a formula, including the definitions that it uses (chosen): fifteen definitions, each
of which uses the next one twice, have more."""

MAX_DEPTH = 64
"""Deepest nesting of operators in a formula, including the definitions that it uses: safe for Python's stack, and for
its compiler (190 nested negations work, 200 do not)."""

MAX_BUILT_DEPTH = 2 * MAX_DEPTH
"""The same for a formula built in Python, where no definition shortens it and one pattern may turn a few levels into 64
(chosen): still safe for stack and compiler."""

Start = Literal["formula", "condition", "definition", "pattern"]

# Unexpected token, often from another language -> advice: how it is written here, or where it is allowed.
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
    '"': "a string ends with the quotation mark that it begins with, on the same line",
    "'": "a string ends with the quotation mark that it begins with, on the same line",
    "[": "`[hysteresis h]` and `[for d]` follow a comparison, `[a:b]` once, historically, count, eventually or always",
}
_TERMINAL_NAMES = {
    "NAME": "a name",
    "NUMBER": "a number",
    "QUANTITY": "a number",
    "RELATION": "a comparison",
    "SIGN": "+ or -",
    "FACTOR": "* or /",
    "TEXT": "a string",
    "$END": "the end of the formula",
}
_WHAT_IS_EXPECTED: dict[Start, str] = {
    "formula": "always(antecedent -> response)",
    "pattern": "the name of a pattern with its arguments, for instance response(on(topic), signal < 0.25, within_s=3)",
    "definition": "a condition, a number or a string, for instance arm_speed > 0.001",
    "condition": "a condition about the present and the past, for instance once[0:2](on(topic)) & signal < 0.25",
}


@cache
def _grammar() -> Lark:
    # The basic lexer recognizes a keyword at any position; the advice for misplaced keywords needs that.
    return lark_parser(
        Path(__file__).parent / "requirement.lark",
        lexer="basic",
        propagate_positions=True,
        start=list(_WHAT_IS_EXPECTED),
        maybe_placeholders=True,
    )


def syntax_tree(source: FormulaSource, start: Start) -> Tree[Token]:
    """Parse a text by the rule `start` of the grammar.

    Raises:
        RequirementError: it is none; the caret marks the first unexpected token. Or it is too long, or nests too
            deeply.
    """
    if len(source.formula) > MAX_LENGTH:
        problem = f"the {start} has {len(source.formula):,} characters; expected at most {MAX_LENGTH:,}"
        raise source.error(0, 1, problem, "name parts of it in [definitions], or split the requirement")
    try:
        tree = _grammar().parse(source.formula, start=start)
    except UnexpectedToken as unexpected:
        raise _error_unexpected(source, start, unexpected) from None
    except UnexpectedCharacters as unexpected:
        position = unexpected.pos_in_stream or 0
        character = source.formula[position]
        problem = f"the character {character!r} has no meaning in a formula"
        raise source.error(position, position + 1, problem, _COMMON_MISTAKES.get(character, "")) from None
    _refuse_deep(source, tree)
    return tree


def _refuse_deep(source: FormulaSource, tree: Tree[Token]) -> None:
    deepest = MAX_BUILT_DEPTH if source.is_built else MAX_DEPTH
    advice = "make two requirements of it" if source.is_built else "give parts names in [definitions]"
    for node, depth in nodes(tree):
        if depth > deepest:
            problem = f"nested too deeply: more than {deepest} levels of operators or parentheses"
            raise source.error(node.meta.start_pos, node.meta.end_pos, problem, advice)


def nodes(tree: Tree[Token]) -> Iterator[tuple[Tree[Token], int]]:
    """All nodes of a tree, each with its depth, from 0 of the tree itself."""
    rest = [(tree, 0)]
    while rest:
        node, depth = rest.pop()
        yield node, depth
        rest += [(child, depth + 1) for child in node.children if isinstance(child, Tree)]


def _error_unexpected(source: FormulaSource, rule: Start, unexpected: UnexpectedToken) -> RequirementError:
    token: Token = unexpected.token
    expected = _expectation(unexpected.accepts or unexpected.expected)
    if token.type == "$END":
        end = len(source.formula.rstrip())
        if end == 0:
            return source.error(0, 1, f"the {rule} is empty", f"expected {_WHAT_IS_EXPECTED[rule]}")
        return source.error(end, end + 1, f"the {rule} ends too early", f"expected {expected}")
    start = token.start_pos or 0
    advice = _COMMON_MISTAKES.get(str(token), "")
    if rule != "formula" and str(token) in ("always", "eventually", "until"):
        rule_text = "an argument of a pattern" if rule == "pattern" else f"a {rule}"
        advice = f"{rule_text} is about the present and the past: write once, historically or since"
    if rule == "pattern" and unexpected.expected == {"NAME"}:
        advice = "this is the name of a pattern with its arguments; for a formula, write the key formula"
    if unexpected.expected == {"ALWAYS"} or (str(token) == ")" and "->" in expected):
        advice = "a requirement says when it applies: always(antecedent -> response)"
    lines = f"expected {expected}" + (f"\n{advice}" if advice else "")
    return source.error(start, start + len(token), f"unexpected {quote(str(token))}", lines)


def _expectation(terminals: set[str]) -> str:
    """The terminals that lark expected, as the user writes them."""
    patterns = {terminal.name: terminal.pattern.value for terminal in _grammar().terminals}
    return _alternatives(sorted({_TERMINAL_NAMES.get(name) or _words(patterns.get(name, name)) for name in terminals}))


def _words(pattern: str) -> str:
    """The words that the pattern of a terminal allows, without what has to follow them; or the symbol."""
    words = re.match(r"\(?([a-z_|]+)(\)|\(\?|$)", pattern)
    return _alternatives(words[1].split("|")) if words else pattern.replace("\\", "")


def _alternatives(names: list[str]) -> str:
    return " or ".join([", ".join(names[:-1]), names[-1]]) if len(names) > 1 else names[0]
