"""Syntax tree to formula: names are looked up in the vocabulary; types, windows and conditions are checked.

Imports lark, so this module is imported only when a formula is parsed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import cast

from lark import Token, Tree

from pytest_hricdv.monitor.analysis import is_instantaneous
from pytest_hricdv.monitor.errors import FormulaSource, RequirementError
from pytest_hricdv.monitor.formula import (
    AlwaysWithin,
    And,
    Arithmetic,
    ArithmeticOperator,
    BooleanName,
    Comparison,
    Eventually,
    Fall,
    FloatName,
    Formula,
    Historically,
    Holds,
    HoldsUntil,
    Negative,
    Not,
    Number,
    On,
    Once,
    Or,
    PastFormula,
    Previously,
    Relation,
    Response,
    Rise,
    Since,
    Term,
)
from pytest_hricdv.monitor.requirement import Kind, Vocabulary
from pytest_hricdv.suggestion import nearest

Node = Tree[Token] | Token


def checked_formula(tree: Tree[Token], source: FormulaSource, vocabulary: Vocabulary) -> Formula:
    """The formula of a syntax tree, with correct names and types.

    Raises:
        RequirementError: an unknown name, a type error, a window that ends before it starts, or a condition that
            can never hold where it stands.
    """
    return _TypeChecker(source, vocabulary).formula(tree)


class _TypeChecker:
    def __init__(self, source: FormulaSource, vocabulary: Vocabulary) -> None:
        self._source = source
        self._vocabulary = vocabulary
        self._past_rules: dict[str, Callable[[Tree[Token]], PastFormula]] = {
            "name": self._boolean_name,
            "on": self._on,
            "comparison": self._comparison,
            "negation": lambda tree: Not(self._past(tree.children[0])),
            "conjunction": lambda tree: And(self._past(tree.children[0]), self._past(tree.children[1])),
            "disjunction": lambda tree: Or(self._past(tree.children[0]), self._past(tree.children[1])),
            "since": lambda tree: Since(self._past(tree.children[0]), self._past(tree.children[1])),
            "parentheses": lambda tree: self._past(tree.children[0]),
            "unary_operator": self._unary_operator,
            "windowed_operator": self._windowed_operator,
        }
        self._term_rules: dict[str, Callable[[Tree[Token]], Term]] = {
            "name": self._float_name,
            "number": lambda tree: Number(self._number(tree.children[0])),
            "signed": self._signed,
            "arithmetic": self._arithmetic,
            "parentheses": lambda tree: self._term(tree.children[0]),
        }

    def formula(self, tree: Tree[Token]) -> Formula:
        _, antecedent_node, response_node = tree.children
        antecedent = self._past(antecedent_node)
        response = self._response(cast("Tree[Token]", response_node))
        if not isinstance(response, Holds) or is_instantaneous(antecedent):
            return Formula(antecedent, response)
        advice = "it would fail right after the instant; did you mean `eventually[0:d](...)`?"
        self._reject_instantaneous(response.condition, response_node, "as long as the antecedent", advice)
        return Formula(antecedent, response)

    def _response(self, tree: Tree[Token]) -> Response:
        parts = [child for child in tree.children if not _is_keyword(child)]
        match tree.data:
            case "holds":
                return Holds(self._past(parts[0]))
            case "holds_until":
                condition = self._past(parts[0])
                self._reject_instantaneous(condition, parts[0], "until a release", "")
                return HoldsUntil(condition, self._past(parts[1]))
        start_s, end_s = self._window(cast("Tree[Token]", parts[0]))
        condition = self._past(parts[1])
        if end_s == 0:
            advice = "for a response at the very instant of the trigger write it without a window"
            raise self._error(parts[0], "a window of a response has to end after the trigger", advice)
        if tree.data == "eventually":
            return Eventually(condition, start_s, end_s)
        self._reject_instantaneous(condition, parts[1], "for a whole window", "")
        return AlwaysWithin(condition, start_s, end_s)

    # --- formulas

    def _past(self, node: Node) -> PastFormula:
        tree = cast("Tree[Token]", node)
        rule = self._past_rules.get(tree.data)
        if rule is None:
            advice = "compare it, for instance `... < 0.25`"
            raise self._error(tree, "expected a condition (true or false), but this is a number", advice)
        return rule(tree)

    def _boolean_name(self, tree: Tree[Token]) -> PastFormula:
        if self._kind(tree) is float:
            advice = "compare it with a bound, for instance `... < 0.25`"
            raise self._error(tree, f"expected a condition, but {tree.children[0]!s} is a float", advice)
        return BooleanName(str(tree.children[0]))

    def _on(self, tree: Tree[Token]) -> PastFormula:
        topic = cast("Token", tree.children[0])
        if topic not in self._vocabulary.messages:
            advice = f"{topic} is a signal; on(...) takes a topic" if topic in self._vocabulary.signals else ""
            problem = f"unknown topic {str(topic)!r}{nearest(topic, self._vocabulary.messages)}"
            raise self._error(topic, problem, advice)
        return On(str(topic))

    def _comparison(self, tree: Tree[Token]) -> PastFormula:
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
        return Comparison(cast("Relation", str(relation)), *sides, values["hysteresis"], values["for"])

    def _unary_operator(self, tree: Tree[Token]) -> PastFormula:
        word, operand_node = tree.children
        operand = self._past(operand_node)
        match str(word):
            case "rise":
                return Rise(operand)
            case "fall":
                return Fall(operand)
        advice = "to ask whether it was true recently, write `once[0:d](...)`"
        self._reject_instantaneous(operand, operand_node, "just before", advice)
        return Previously(operand)

    def _windowed_operator(self, tree: Tree[Token]) -> PastFormula:
        word, window, operand_node = tree.children
        start_s, end_s = (0.0, math.inf) if window is None else self._window(cast("Tree[Token]", window))
        operand = self._past(operand_node)
        if str(word) == "once":
            return Once(operand, start_s, end_s)
        self._reject_instantaneous(operand, operand_node, "for a length of time", "")
        return Historically(operand, start_s, end_s)

    def _window(self, tree: Tree[Token]) -> tuple[float, float]:
        first, second = (cast("Token", child) for child in tree.children)
        start_s = self._number(first)
        end_s = math.inf if second.type == "INF" else self._number(second)
        if end_s < start_s:
            raise self._error(tree, f"a window [a:b] needs a <= b, got [{first}:{second}]", "times are in seconds")
        return start_s, end_s

    # --- terms

    def _term(self, node: Node) -> Term:
        tree = cast("Tree[Token]", node)
        rule = self._term_rules.get(tree.data)
        if rule is None:
            advice = "comparisons take numbers; put parentheses around a comparison inside a formula"
            raise self._error(tree, "expected a number, but this is a condition (true or false)", advice)
        return rule(tree)

    def _float_name(self, tree: Tree[Token]) -> Term:
        if self._kind(tree) is bool:
            name = str(tree.children[0])
            advice = f"use it as a condition by itself: `{name}` or `!{name}`"
            raise self._error(tree, f"expected a number, but {name} is a bool", advice)
        return FloatName(str(tree.children[0]))

    def _signed(self, tree: Tree[Token]) -> Term:
        sign, operand = tree.children
        return Negative(self._term(operand)) if str(sign) == "-" else self._term(operand)

    def _arithmetic(self, tree: Tree[Token]) -> Term:
        left, operator, right = tree.children
        return Arithmetic(cast("ArithmeticOperator", str(operator)), self._term(left), self._term(right))

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

    def _reject_instantaneous(self, formula: PastFormula, node: Node, where: str, advice: str) -> None:
        if is_instantaneous(formula):
            problem = f"this is true for single instants only (on, rise, fall), so it can never hold {where}"
            raise self._error(node, problem, advice)

    def _error(self, node: Node, problem: str, advice: str = "") -> RequirementError:
        if isinstance(node, Token):
            return self._source.error(node.start_pos or 0, node.end_pos or 0, problem, advice)
        return self._source.error(node.meta.start_pos, node.meta.end_pos, problem, advice)


def _is_keyword(node: Node) -> bool:
    return isinstance(node, Token)
