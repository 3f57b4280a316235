"""`TermParser`, the base class of the parsers of numbers and formulas: resolves names, checks types, parses strings."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import TypeAlias, cast

from lark import Token, Tree

from pytest_hricdv._base.message import nearest, quote
from pytest_hricdv.monitor.node import Kind, PastFormula, TextTerm, field_of, last_of
from pytest_hricdv.monitor.requirement import FormulaSource, RequirementError
from pytest_hricdv.monitor.syntax_tree import MAX_NODES
from pytest_hricdv.monitor.terms import Text, TextName
from pytest_hricdv.monitor.units import QuantityTerm
from pytest_hricdv.monitor.vocabulary import Vocabulary

Node: TypeAlias = "Tree[Token] | Token"

_NOUNS: dict[Kind, str] = {bool: "a condition", float: "a number", str: "a string"}
_EXAMPLES: dict[Kind, str] = {float: "`... < 0.25`", str: '`... == "..."`'}


class UnknownOperatorError(Exception):
    """The grammar has a rule or a word that the parser does not know: an internal error."""

    def __init__(self, rule: str, word: str = "") -> None:
        operator = f"operator {word!r}" if word else "operator"
        super().__init__(f"unknown {operator}: the parser has no case for it in the rule {rule!r} of requirement.lark")


class TermParser(ABC):
    """Resolves the names in a syntax tree, checks the types of expressions, and parses texts.

    Args:
        source: the source of the text.
        vocabulary: the names that it may use.
    """

    def __init__(self, source: FormulaSource, vocabulary: Vocabulary) -> None:
        self._source = source
        self._vocabulary = vocabulary
        self.used: dict[str, None] = {}  # the definitions in the text so far, used as an ordered set
        self._past_rules: dict[str, Callable[[Tree[Token]], PastFormula]] = {}
        self._number_rules: dict[str, Callable[[Tree[Token]], QuantityTerm]] = {}
        self._expanded = 0  # operators and operands of these definitions, each as often as it is used

    @abstractmethod
    def _past(self, node: Node) -> PastFormula:
        """The formula of a condition."""

    # --- types

    def _kind(self, node: Node) -> Kind:
        """The type of an expression, by its outermost operator."""
        tree = _inside(node)
        match tree.data:
            case "name" | "last":
                return self._kind_of_name(tree)
            case "text":
                return str
            case rule if rule in self._past_rules:
                return bool
            case rule if rule in self._number_rules:
                return float
            case rule:
                raise UnknownOperatorError(rule)

    def _kind_of_name(self, tree: Tree[Token]) -> Kind:
        name = str(tree.children[-1])
        full_name = self._vocabulary.full_name(name)
        kind = self._vocabulary.kind(full_name)
        if kind is not None and tree.data == "last" and "." not in full_name:
            advice = "last(topic.field) is the value in the message before the present one"
            noun = "a definition" if name in self._vocabulary.definitions else "a signal"
            raise self._error(tree.children[-1], f"expected a field of a message, but {name} is {noun}", advice)
        if kind is not None:
            return kind
        if name in self._vocabulary.messages:
            advice = f"{name} is a topic: `on({name})` is true when a message arrives, `{name}.field` is its last value"
            raise self._error(tree, f"unknown name {quote(name)}", advice)
        raise self._error(tree, f"unknown name {quote(name)}{nearest(name, self._vocabulary.names())}")

    def _full_name(self, tree: Tree[Token]) -> str:
        name = self._vocabulary.full_name(str(tree.children[-1]))
        return last_of(name) if tree.data == "last" else name

    def _meaning(self, tree: Tree[Token]) -> PastFormula | QuantityTerm | TextTerm | None:
        """The definition of a name; None if it has none."""
        name = str(tree.children[-1])
        definition = self._vocabulary.definitions.get(name)
        if definition is None:
            return None
        self.used[name] = None
        self._expanded += definition.nodes
        if self._expanded > MAX_NODES:
            problem = f"with what the definitions stand for, this has more than {MAX_NODES} operators and operands"
            raise self._error(tree, problem, "definitions that use others several times grow fast")
        return definition.meaning

    def _expect(self, node: Node, expected: Kind) -> Tree[Token]:
        """Check the type of a node; returns it without parentheses."""
        tree = _inside(node)
        kind = self._kind(tree)
        if kind is expected:
            return tree
        is_name = tree.data == "name"
        actual = f"{tree.children[-1]!s} is a {kind.__name__}" if is_name else f"this is {_NOUNS[kind]}"
        problem = f"expected {_NOUNS[expected]}, but {actual}"
        if expected is bool:
            advice = f"compare it, for instance {_EXAMPLES[kind]}"
        elif is_name and kind is bool:
            advice = f"use it as a condition by itself: `{tree.children[0]!s}` or `!{tree.children[0]!s}`"
        elif kind is bool:
            advice = "comparisons take numbers or strings; put parentheses around a comparison inside a formula"
        else:
            advice = "a number is compared with a number, a string with a string"
        raise self._error(tree, problem, advice)

    # --- texts

    def _text(self, node: Node) -> TextTerm:
        tree = self._expect(node, str)
        if tree.data == "text":
            return Text(str(tree.children[0])[1:-1])
        return cast("TextTerm", self._meaning(tree) or TextName(self._full_name(tree)))

    def _compares_texts(self, left: Node, right: Node) -> bool:
        for node, other in ((left, right), (right, left)):
            if self._is_unknown(node) and not self._is_unknown(other) and self._kind(other) is str:
                name = str(_inside(node).children[0])
                raise self._error(
                    node, f"unknown name {quote(name)}", f'a string is written in quotation marks: "{name}"'
                )
        return str in (self._kind(left), self._kind(right))

    def _is_unknown(self, node: Node) -> bool:
        tree = _inside(node)
        return tree.data == "name" and self._vocabulary.kind(self._full_name(tree)) is None

    def _texts(self, left: Node, right: Node) -> tuple[TextTerm, TextTerm]:
        """Both sides of a comparison of texts."""
        sides = self._text(left), self._text(right)
        for node, side, other in ((left, sides[0], sides[1]), (right, sides[1], sides[0])):
            if isinstance(side, Text) and isinstance(other, TextName):
                self._check_value(node, side.value, other.name)
        return sides

    def _check_value(self, node: Node, value: str, name: str) -> None:
        allowed = self._vocabulary.values.get(field_of(name) or name)
        if allowed is not None and value not in allowed:
            raise self._error(node, f"{name} is never {value!r}{nearest(value, allowed)}")

    # --- errors

    def _reject_instantaneous(self, formula: PastFormula, node: Node, where: str, advice: str) -> None:
        if formula.is_instantaneous:
            problem = f"this is true for single instants only (on, rise, fall), so it can never hold {where}"
            raise self._error(node, problem, advice)

    def _error(self, node: Node, problem: str, advice: str = "") -> RequirementError:
        if isinstance(node, Token):
            return self._source.error(node.start_pos or 0, node.end_pos or 0, problem, advice)
        return self._source.error(node.meta.start_pos, node.meta.end_pos, problem, advice)


def _inside(node: Node) -> Tree[Token]:
    """A node without the parentheses around it."""
    tree = cast("Tree[Token]", node)
    return _inside(tree.children[0]) if tree.data == "parentheses" else tree
