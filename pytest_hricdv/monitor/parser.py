"""Text of a formula to the formula: syntax, then names, types, windows and conditions; errors in the user's terms.

Imports lark, so this module is imported only when a formula is parsed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import cast

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedToken

from pytest_hricdv.grammar import lark_parser
from pytest_hricdv.monitor import formula as ast
from pytest_hricdv.monitor.analysis import is_instantaneous
from pytest_hricdv.monitor.requirement import FormulaSource, Kind, RequirementError, Vocabulary
from pytest_hricdv.suggestion import nearest

Node = Tree[Token] | Token

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


def parse(source: FormulaSource, vocabulary: Vocabulary) -> ast.Formula:
    """The formula that a text means.

    Raises:
        RequirementError: the text is not a formula (the caret marks the first unexpected token); an unknown name, a
            type error, a window that ends before it starts, or a condition that can never hold where it stands.
    """
    return _TypeChecker(source, vocabulary).formula(_syntax_tree(source))


# --- syntax


@cache
def _grammar() -> Lark:
    # The basic lexer recognizes a keyword at any position; the advice for misplaced keywords needs that.
    return lark_parser(
        Path(__file__).parent / "requirement.lark",
        lexer="basic",
        propagate_positions=True,
        maybe_placeholders=True,
    )


def _syntax_tree(source: FormulaSource) -> Tree[Token]:
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


# --- names and types


class _TypeChecker:
    """Makes the formula from the syntax tree, with the rule of the same name for each node."""

    def __init__(self, source: FormulaSource, vocabulary: Vocabulary) -> None:
        self._source = source
        self._vocabulary = vocabulary
        self._past_rules: dict[str, Callable[[Tree[Token]], ast.PastFormula]] = {
            "name": self._boolean_name,
            "on": self._on,
            "comparison": self._comparison,
            "negation": lambda tree: ast.Not(self._past(tree.children[0])),
            "conjunction": lambda tree: ast.And(self._past(tree.children[0]), self._past(tree.children[1])),
            "disjunction": lambda tree: ast.Or(self._past(tree.children[0]), self._past(tree.children[1])),
            "since": lambda tree: ast.Since(self._past(tree.children[0]), self._past(tree.children[1])),
            "parentheses": lambda tree: self._past(tree.children[0]),
            "unary_operator": self._unary_operator,
            "windowed_operator": self._windowed_operator,
        }
        self._term_rules: dict[str, Callable[[Tree[Token]], ast.Term]] = {
            "name": self._float_name,
            "number": lambda tree: ast.Number(self._number(tree.children[0])),
            "signed": self._signed,
            "arithmetic": self._arithmetic,
            "parentheses": lambda tree: self._term(tree.children[0]),
        }

    def formula(self, tree: Tree[Token]) -> ast.Formula:
        _, antecedent_node, response_node = tree.children
        antecedent = self._past(antecedent_node)
        response = self._response(cast("Tree[Token]", response_node))
        if not isinstance(response, ast.Holds) or is_instantaneous(antecedent):
            return ast.Formula(antecedent, response)
        advice = "it would fail right after the instant; did you mean `eventually[0:d](...)`?"
        self._reject_instantaneous(response.condition, response_node, "as long as the antecedent", advice)
        return ast.Formula(antecedent, response)

    def _response(self, tree: Tree[Token]) -> ast.Response:
        parts = [child for child in tree.children if not _is_keyword(child)]
        match tree.data:
            case "holds":
                return ast.Holds(self._past(parts[0]))
            case "holds_until":
                condition = self._past(parts[0])
                self._reject_instantaneous(condition, parts[0], "until a release", "")
                return ast.HoldsUntil(condition, self._past(parts[1]))
        start_s, end_s = self._window(cast("Tree[Token]", parts[0]))
        condition = self._past(parts[1])
        if end_s == 0:
            advice = "for a response at the very instant of the trigger write it without a window"
            raise self._error(parts[0], "a window of a response has to end after the trigger", advice)
        if tree.data == "eventually":
            return ast.Eventually(condition, start_s, end_s)
        self._reject_instantaneous(condition, parts[1], "for a whole window", "")
        return ast.AlwaysWithin(condition, start_s, end_s)

    # --- formulas

    def _past(self, node: Node) -> ast.PastFormula:
        tree = cast("Tree[Token]", node)
        rule = self._past_rules.get(tree.data)
        if rule is None:
            advice = "compare it, for instance `... < 0.25`"
            raise self._error(tree, "expected a condition (true or false), but this is a number", advice)
        return rule(tree)

    def _boolean_name(self, tree: Tree[Token]) -> ast.PastFormula:
        if self._kind(tree) is float:
            advice = "compare it with a bound, for instance `... < 0.25`"
            raise self._error(tree, f"expected a condition, but {tree.children[0]!s} is a float", advice)
        return ast.BooleanName(str(tree.children[0]))

    def _on(self, tree: Tree[Token]) -> ast.PastFormula:
        topic = cast("Token", tree.children[0])
        if topic not in self._vocabulary.messages:
            advice = f"{topic} is a signal; on(...) takes a topic" if topic in self._vocabulary.signals else ""
            problem = f"unknown topic {str(topic)!r}{nearest(topic, self._vocabulary.messages)}"
            raise self._error(topic, problem, advice)
        return ast.On(str(topic))

    def _comparison(self, tree: Tree[Token]) -> ast.PastFormula:
        left, relation, right, *qualifiers = tree.children
        values = {"hysteresis": 0.0, "for": 0.0}
        given: set[str] = set()
        for qualifier in qualifiers:
            word, number = cast("Tree[Token]", qualifier).children
            if word in given:
                raise self._error(qualifier, f"`{word}` is given twice")
            given.add(str(word))
            values[str(word)] = self._number(number)
        if "hysteresis" in given and str(relation) in ("==", "!="):
            raise self._error(relation, "a hysteresis needs a bound with two sides: < <= > >=")
        sides = self._term(left), self._term(right)
        return ast.Comparison(cast("ast.Relation", str(relation)), *sides, values["hysteresis"], values["for"])

    def _unary_operator(self, tree: Tree[Token]) -> ast.PastFormula:
        word, operand_node = tree.children
        operand = self._past(operand_node)
        match str(word):
            case "rise":
                return ast.Rise(operand)
            case "fall":
                return ast.Fall(operand)
        advice = "to ask whether it was true recently, write `once[0:d](...)`"
        self._reject_instantaneous(operand, operand_node, "just before", advice)
        return ast.Previously(operand)

    def _windowed_operator(self, tree: Tree[Token]) -> ast.PastFormula:
        word, window, operand_node = tree.children
        start_s, end_s = (0.0, math.inf) if window is None else self._window(cast("Tree[Token]", window))
        operand = self._past(operand_node)
        if str(word) == "once":
            return ast.Once(operand, start_s, end_s)
        self._reject_instantaneous(operand, operand_node, "for a length of time", "")
        return ast.Historically(operand, start_s, end_s)

    def _window(self, tree: Tree[Token]) -> tuple[float, float]:
        first, second = (cast("Token", child) for child in tree.children)
        start_s = self._number(first)
        end_s = math.inf if second.type == "INF" else self._number(second)
        if end_s < start_s:
            raise self._error(tree, f"a window [a:b] needs a <= b, got [{first}:{second}]", "times are in seconds")
        return start_s, end_s

    # --- terms

    def _term(self, node: Node) -> ast.Term:
        tree = cast("Tree[Token]", node)
        rule = self._term_rules.get(tree.data)
        if rule is None:
            advice = "comparisons take numbers; put parentheses around a comparison inside a formula"
            raise self._error(tree, "expected a number, but this is a condition (true or false)", advice)
        return rule(tree)

    def _float_name(self, tree: Tree[Token]) -> ast.Term:
        if self._kind(tree) is bool:
            name = str(tree.children[0])
            advice = f"use it as a condition by itself: `{name}` or `!{name}`"
            raise self._error(tree, f"expected a number, but {name} is a bool", advice)
        return ast.FloatName(str(tree.children[0]))

    def _signed(self, tree: Tree[Token]) -> ast.Term:
        sign, operand = tree.children
        return ast.Negative(self._term(operand)) if str(sign) == "-" else self._term(operand)

    def _arithmetic(self, tree: Tree[Token]) -> ast.Term:
        left, operator, right = tree.children
        return ast.Arithmetic(cast("ast.ArithmeticOperator", str(operator)), self._term(left), self._term(right))

    def _number(self, node: Node) -> float:
        value = float(cast("Token", node))
        if not math.isfinite(value):
            raise self._error(node, "this number is too large for a float")
        return value

    # --- names and errors

    def _kind(self, tree: Tree[Token]) -> Kind:
        name = str(tree.children[0])
        kind = self._vocabulary.kind(name)
        if kind is not None:
            return kind
        if name in self._vocabulary.messages:
            advice = f"{name} is a topic: `on({name})` is true when a message arrives, `{name}.field` is its last value"
            raise self._error(tree, f"unknown name {name!r}", advice)
        raise self._error(tree, f"unknown name {name!r}{nearest(name, self._vocabulary.names())}")

    def _reject_instantaneous(self, formula: ast.PastFormula, node: Node, where: str, advice: str) -> None:
        if is_instantaneous(formula):
            problem = f"this is true for single instants only (on, rise, fall), so it can never hold {where}"
            raise self._error(node, problem, advice)

    def _error(self, node: Node, problem: str, advice: str = "") -> RequirementError:
        if isinstance(node, Token):
            return self._source.error(node.start_pos or 0, node.end_pos or 0, problem, advice)
        return self._source.error(node.meta.start_pos, node.meta.end_pos, problem, advice)


def _is_keyword(node: Node) -> bool:
    return isinstance(node, Token)
