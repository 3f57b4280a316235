"""`FormulaParser` turns syntax trees of requirements into formulas; it checks names, types, units and windows.

`load_requirements` and `parse_formula` use its subclass `RequirementParser`, which parses patterns, too. The module
imports lark, so it is imported only when a formula is parsed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import cast

from lark import Token, Tree

from pytest_hricdv._base.message import nearest, quote
from pytest_hricdv.monitor.formula import AlwaysWithin, Eventually, Formula, Holds, HoldsUntil, Response
from pytest_hricdv.monitor.node import PastFormula, Term
from pytest_hricdv.monitor.number_parser import NumberParser
from pytest_hricdv.monitor.past_formula import (
    FLIPPED,
    OPERATORS,
    BooleanName,
    Conjunction,
    Disjunction,
    Equality,
    Negation,
    NumberComparison,
    On,
    Relation,
    Since,
    TextComparison,
)
from pytest_hricdv.monitor.requirement import FormulaSource
from pytest_hricdv.monitor.syntax_tree import MAX_DEPTH, nodes, syntax_tree
from pytest_hricdv.monitor.term_parser import Node, UnknownOperatorError
from pytest_hricdv.monitor.terms import Count, NumberTerm, TimeBetween, TimeSince, leaves
from pytest_hricdv.monitor.units import QuantityTerm, constant
from pytest_hricdv.monitor.vocabulary import Definition, Vocabulary


class FormulaParser(NumberParser):
    """Makes the formula of a text from its syntax tree, with one rule for each type of node.

    Its methods raise RequirementError for a syntax error (the caret marks the first unexpected token), an unknown name,
    a type error, a window that ends before it starts, or a condition that can never hold where it stands.
    """

    def __init__(self, source: FormulaSource, vocabulary: Vocabulary) -> None:
        super().__init__(source, vocabulary)
        self._past_rules |= {
            "name": lambda tree: cast("PastFormula", self._meaning(tree) or BooleanName(self._full_name(tree))),
            "last": lambda tree: BooleanName(self._full_name(tree)),
            "on": self._on,
            "comparison": self._comparison,
            "negation": lambda tree: Negation(self._past(tree.children[0])),
            "conjunction": lambda tree: Conjunction(*map(self._past, tree.children)),
            "disjunction": lambda tree: Disjunction(*map(self._past, tree.children)),
            "since": lambda tree: Since(self._past(tree.children[0]), self._past(tree.children[1])),
            "operator": self._operator,
        }

    @classmethod
    def define(cls, sources: Mapping[str, FormulaSource], vocabulary: Vocabulary) -> Vocabulary:
        """The vocabulary with definitions, name -> text; they may use each other, in any order, but not in a circle.

        Raises ValueError for a name that no definition can have.
        """
        trees = {name: syntax_tree(source, "definition") for name, source in sources.items()}
        pending: list[str] = []

        def add(name: str, user: Token | None) -> None:
            nonlocal vocabulary
            if name in pending and user is not None:
                circle = " -> ".join([*pending[pending.index(name) :], name])
                advice = "each has to lead back to signals and messages"
                problem = f"definitions use each other in a circle: {circle}"
                raise sources[pending[-1]].error(user.start_pos or 0, user.end_pos or 0, problem, advice)
            if len(pending) > MAX_DEPTH:  # `add` calls itself for each
                problem = f"more than {MAX_DEPTH} definitions that use each other"
                raise sources[name].error(0, 1, problem, "define it by signals and messages directly")
            pending.append(name)
            for node in trees[name].find_data("name"):
                token = cast("Token", node.children[0])
                if token in trees and token not in vocabulary.definitions:
                    add(str(token), token)
            pending.pop()
            vocabulary = vocabulary.define(name, cls(sources[name], vocabulary)._definition(trees[name]))

        for name in trees:
            if name not in vocabulary.definitions:
                add(name, None)
        return vocabulary

    def condition(self) -> PastFormula:
        """The past formula that the text means."""
        return self._past(syntax_tree(self._source, "condition").children[0])

    def _definition(self, tree: Tree[Token]) -> Definition:
        node = tree.children[0]
        kind = self._kind(node)
        meaning = self._past(node) if kind is bool else self._quantity(node) if kind is float else self._text(node)
        sizes = [depth for _, depth in nodes(tree)]
        depth = max(sizes) + max((self._vocabulary.definitions[name].depth for name in self.used), default=0)
        if depth > MAX_DEPTH:
            problem = f"nested too deeply: with the definitions in it, more than {MAX_DEPTH} levels of operators"
            raise self._error(node, problem)
        text, uses = self._source.formula.strip(), frozenset(self.used)
        return Definition(text, kind, meaning, uses, len(sizes) + self._expanded, depth)

    def formula(self) -> Formula:
        """The formula of a requirement that the text means."""
        _, antecedent_node, response_node = syntax_tree(self._source, "formula").children
        antecedent = self._past(antecedent_node)
        response = self._response(cast("Tree[Token]", response_node))
        if not isinstance(response, Holds) or antecedent.is_instantaneous:
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
            case "eventually" | "always_within":
                return self._response_in_window(tree, parts)
            case rule:
                raise UnknownOperatorError(rule)

    def _response_in_window(self, tree: Tree[Token], parts: Sequence[Node]) -> Response:
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
        tree = self._expect(node, bool)
        return self._past_rules[tree.data](tree)

    def _on(self, tree: Tree[Token]) -> PastFormula:
        topic = cast("Token", tree.children[0])
        if topic not in self._vocabulary.messages:
            kind = "a definition" if topic in self._vocabulary.definitions else "a signal"
            is_declared = self._vocabulary.kind(topic) is not None
            advice = f"{topic} is {kind}; on(...) takes a topic" if is_declared else ""
            problem = f"unknown topic {quote(str(topic))}{nearest(topic, self._vocabulary.messages)}"
            raise self._error(topic, problem, advice)
        return On(str(topic))

    def _comparison(self, tree: Tree[Token]) -> PastFormula:
        left, relation, right, *qualifier_nodes = tree.children
        of_texts = self._compares_texts(left, right)
        if of_texts and str(relation) not in ("==", "!="):
            raise self._error(relation, "strings are compared with == or !=")
        qualifiers = self._qualifiers(qualifier_nodes)
        if unknown := qualifiers.keys() - {"for", "hysteresis"}:
            raise UnknownOperatorError("qualifier", min(unknown))
        for_s = self._seconds(qualifiers["for"]) if "for" in qualifiers else 0.0
        if "hysteresis" in qualifiers and str(relation) in ("==", "!="):
            raise self._error(relation, "a hysteresis needs a bound with two sides: < <= > >=")
        if of_texts:
            return TextComparison(cast("Equality", str(relation)), *self._texts(left, right), for_s)
        sides = self._in_one_unit(left, self._quantity(left), right, self._quantity(right))
        terms = sides[0].term, sides[1].term
        if any(isinstance(term, TimeSince) for term in terms):
            return self._time_since(tree, *terms)
        width = self._width(qualifiers["hysteresis"], (left, right), sides) if "hysteresis" in qualifiers else 0.0
        return NumberComparison(cast("Relation", str(relation)), *terms, width, for_s)

    def _width(self, node: Node, nodes: tuple[Node, Node], sides: tuple[QuantityTerm, QuantityTerm]) -> float:
        """The width of a hysteresis, in the unit of the comparison."""
        if any(isinstance(leaf, Count | TimeBetween) for side in sides for leaf in leaves(side.term)):
            raise self._error(node, "a hysteresis is for measured numbers; counts and times have no noise")
        width = self._constant(node)
        if width.unit is not None:
            # Converted to the unit of the side that has one; if both have, of the one that is measured.
            side = max((0, 1), key=lambda n: (sides[n].unit is not None, sides[n].origin == "value"))
            width = self._in_unit_of(nodes[side], sides[side], node, width)
        return float(constant(width.term))

    def _time_since(self, tree: Tree[Token], left: Term, right: Term) -> PastFormula:
        """A comparison of `time_since`, which is written on the left."""
        relation = cast("Relation", str(tree.children[1]))
        advice = "for instance `time_since(f) < 3`; `time_between(f, g)` is a number like others"
        if len(tree.children) > 3:
            raise self._error(tree.children[3], "a comparison of time_since has no [hysteresis] and no [for]")
        if relation in ("==", "!="):
            raise self._error(tree.children[1], "time_since changes all the time: compare it with < <= > >=", advice)
        if isinstance(right, TimeSince) and isinstance(left, NumberTerm):
            self._check_time(tree.children[0], left.value)
            return NumberComparison(FLIPPED[relation], right, left)
        if not isinstance(right, NumberTerm):
            node = tree.children[2] if isinstance(left, TimeSince) else tree.children[0]
            raise self._error(node, "a time_since is compared with a number of seconds", advice)
        self._check_time(tree.children[2], right.value)
        return NumberComparison(relation, left, right)

    def _qualifiers(self, nodes: Sequence[Node]) -> dict[str, Node]:
        """The qualifiers of a comparison: word -> its number."""
        numbers: dict[str, Node] = {}
        for node in nodes:
            word, number = cast("Tree[Token]", node).children
            if str(word) in numbers:
                raise self._error(node, f"`{word!s}` is given twice")
            numbers[str(word)] = number
        return numbers

    def _operator(self, tree: Tree[Token]) -> PastFormula:
        formula = self._apply(tree, OPERATORS)
        if where := formula.NEVER_OF_INSTANTS:
            self._reject_instantaneous(formula.operand, tree.children[-1], where, formula.ADVICE)
        return formula


def _is_keyword(node: Node) -> bool:
    return isinstance(node, Token)
