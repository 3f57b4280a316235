"""`NumberParser` parses constants, arithmetic, counts and units; `FormulaParser` adds conditions and responses."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from typing import TypeVar, cast

from lark import Token, Tree

from pytest_hricdv._base.message import nearest, quote
from pytest_hricdv.monitor.node import Term
from pytest_hricdv.monitor.requirement import FormulaSource
from pytest_hricdv.monitor.term_parser import Node, TermParser, UnknownOperatorError
from pytest_hricdv.monitor.terms import (
    PAST_NUMBERS,
    ArithmeticOperator,
    ArithmeticTerm,
    FloatName,
    Negative,
    NumberTerm,
    TimeSince,
)
from pytest_hricdv.monitor.units import (
    MAX_TIME_S,
    NO_UNIT,
    SECOND,
    QuantityTerm,
    Unit,
    constant,
    constant_term,
    unit_names,
    unit_of,
)
from pytest_hricdv.monitor.vocabulary import Vocabulary

# A number, with what is left as its unit. The grammar has checked the form: this only takes it apart.
_QUANTITY = re.compile(r"([\d.]+(?:[eE][+-]?\d+)?)\s*(.*)")

T = TypeVar("T")


class NumberParser(TermParser):
    """Makes terms from syntax trees, with the rule of the same name for each node.

    A number with a unit is converted to the unit of what it is compared with or added to, so that a formula has plain
    numbers only. Where a unit is written, both sides need one; elsewhere, signals of different units are not compared.
    """

    def __init__(self, source: FormulaSource, vocabulary: Vocabulary) -> None:
        super().__init__(source, vocabulary)
        self._number_rules |= {
            "name": self._name,
            "last": self._name,
            "number_operator": self._number_operator,
            "number": lambda tree: self._constant(tree.children[0]),
            "signed": self._sign,
            "arithmetic": self._arithmetic,
        }

    def _quantity(self, node: Node) -> QuantityTerm:
        """The term of a number, with its unit."""
        tree = self._expect(node, float)
        return self._number_rules[tree.data](tree)

    def _name(self, tree: Tree[Token]) -> QuantityTerm:
        meaning, name = self._meaning(tree), self._full_name(tree)
        if meaning is not None:
            return cast("QuantityTerm", meaning)
        return QuantityTerm(FloatName(name), self._vocabulary.unit(name), "value")

    def _number_operator(self, tree: Tree[Token]) -> QuantityTerm:
        number = self._apply(tree, PAST_NUMBERS)
        return QuantityTerm(number, unit_of(number.UNIT), "value")

    def _apply(self, tree: Tree[Token], operators: Mapping[str, type[T]]) -> T:
        """The meaning of an operator written as a function, with a window if its class has one."""
        word, *nodes = tree.children
        operator = operators.get(str(word))
        if operator is None:
            raise UnknownOperatorError(tree.data, str(word))
        window: tuple[float, ...] = ()
        if hasattr(operator, "start_s"):
            first = nodes.pop(0)
            window = (0.0, math.inf) if first is None else self._window(cast("Tree[Token]", first))
        return cast("Callable[..., T]", operator)(*map(self._past, nodes), *window)

    # --- constants

    def _constant(self, node: Node) -> QuantityTerm:
        """A number as it is written, with or without a unit."""
        token = cast("Token", node)
        written = cast("re.Match[str]", _QUANTITY.fullmatch(token))
        value = float(written[1])
        if not math.isfinite(value):
            raise self._error(node, "this number is too large for a float")
        if written[1].isdigit() and int(written[1]) != value:
            raise self._error(node, f"this number has too many digits for a float, which is {value:.0f}")
        if not written[2]:
            return QuantityTerm(NumberTerm(value), None, "number")
        unit = unit_of(written[2])
        if not unit.is_known and unit.text not in self._vocabulary.units.values():
            advice = "a product of a number and a name is written with `*`"
            suggestion = nearest(unit.text, [*unit_names(), *self._vocabulary.units.values()])
            raise self._error(node, f"unknown unit {quote(unit.text)}{suggestion}", advice)
        return QuantityTerm(NumberTerm(value), unit, "quantity")

    def _seconds(self, node: Node) -> float:
        """A time that is written without a unit, in seconds, or with one."""
        time = self._constant(node)
        time_s = float(constant(self._to_unit(node, time, SECOND).term if time.unit else time.term))
        self._check_time(node, time_s)
        return time_s

    def _check_time(self, node: Node, time_s: float) -> None:
        if time_s > MAX_TIME_S:
            raise self._error(
                node, f"expected a time of at most {MAX_TIME_S:g} s", "`inf` is not allowed, as in [0:inf]"
            )

    def _window(self, tree: Tree[Token]) -> tuple[float, float]:
        first, second = (cast("Token", child) for child in tree.children)
        start_s = self._seconds(first)
        end_s = math.inf if second.type == "INF" else self._seconds(second)
        if end_s < start_s:
            raise self._error(tree, f"a window [a:b] needs a <= b, got [{first}:{second}]", "times are in seconds")
        return start_s, end_s

    # --- arithmetic

    def _operand(self, node: Node) -> QuantityTerm:
        """A number that can be a part of others."""
        measured = self._quantity(node)
        if isinstance(measured.term, TimeSince):
            advice = "`time_between(f, g)` is a number like others"
            problem = "a time_since is compared with a number of seconds, as in `time_since(f) < 3`"
            raise self._error(node, problem, advice)
        return measured

    def _sign(self, tree: Tree[Token]) -> QuantityTerm:
        sign, node = tree.children
        operand = self._operand(node)
        if str(sign) == "+":
            return operand
        if str(sign) != "-":
            raise UnknownOperatorError(tree.data, str(sign))
        return QuantityTerm(Negative(operand.term), operand.unit, operand.origin, operand.exact)

    def _arithmetic(self, tree: Tree[Token]) -> QuantityTerm:
        left_node, operator, right_node = tree.children
        left, right = self._operand(left_node), self._operand(right_node)
        symbol = cast("ArithmeticOperator", str(operator))
        if symbol in ("+", "-"):
            left, right = self._in_one_unit(left_node, left, right_node, right)
            unit, exact = left.unit or right.unit, left.exact and right.exact
        elif symbol in ("*", "/"):
            # A quantity is a factor in its base units, so that the unit of a product needs no numbers of its own.
            left, right = self._in_base_unit(left_node, left), self._in_base_unit(right_node, right)
            unit, exact = _product_unit(left, right, symbol)
        else:
            raise UnknownOperatorError(tree.data, symbol)
        term, origins = ArithmeticTerm(symbol, left.term, right.term), (left.origin, right.origin)
        if "value" in origins:
            return QuantityTerm(term, unit, "value", exact)
        return (
            QuantityTerm(self._evaluate(tree, term), unit, "quantity") if unit else QuantityTerm(term, None, "number")
        )

    def _evaluate(self, tree: Tree[Token], term: Term) -> Term:
        """The constant that a computation with quantities makes, so that it can be converted."""
        try:
            return constant_term(constant(term))
        except (ZeroDivisionError, OverflowError) as error:
            raise self._error(tree, f"this is not a finite number: {error}") from None

    # --- units

    def _in_one_unit(
        self, left_node: Node, left: QuantityTerm, right_node: Node, right: QuantityTerm
    ) -> tuple[QuantityTerm, QuantityTerm]:
        """Both sides of a comparison or of a sum, quantities in the unit of the other side."""
        if right.origin == "quantity":
            return left, self._in_unit_of(left_node, left, right_node, right)
        if left.origin == "quantity":
            return self._in_unit_of(right_node, right, left_node, left), right
        units = left.unit, right.unit
        if all(unit is not None and unit.is_known for unit in units) and left.exact and right.exact:
            self._require_equal(right_node, cast("Unit", left.unit), cast("Unit", right.unit))
        return left, right

    def _in_unit_of(
        self, node: Node, measure: QuantityTerm, quantity_node: Node, quantity: QuantityTerm
    ) -> QuantityTerm:
        if measure.unit is None:
            number = measure.origin == "number"
            problem = "this number has no unit, and the other one has" if number else "no unit is declared for this"
            advice = "write a unit for both" if number else "declare it in the testbench's units, or write no unit"
            raise self._error(node, problem, advice)
        return self._to_unit(quantity_node, quantity, measure.unit)

    def _to_unit(self, node: Node, quantity: QuantityTerm, unit: Unit) -> QuantityTerm:
        assert quantity.unit is not None
        if quantity.unit.dimension != unit.dimension:
            expected = f"expected a number in {unit.text}" if unit.text else "expected a number without a unit"
            raise self._error(node, f"{expected}, got one in {quantity.unit.text}")
        try:
            return quantity.to_unit(unit)
        except OverflowError:
            raise self._error(node, f"this number is too large for a float in {unit.text}") from None

    def _in_base_unit(self, node: Node, measured: QuantityTerm) -> QuantityTerm:
        if measured.origin != "quantity" or measured.unit is None:
            return measured
        return self._to_unit(node, measured, measured.unit.base)

    def _require_equal(self, node: Node, left: Unit, right: Unit) -> None:
        if left.dimension != right.dimension:
            raise self._error(node, f"this is in {right.text or 'no unit'}, the other side in {left.text or 'no unit'}")
        if left.scale != right.scale:
            factor = float(right.scale / left.scale)
            advice = f"signals are not converted: multiply it by {factor:g}"
            raise self._error(node, f"this is in {right.text}, the other side in {left.text}", advice)


def _product_unit(left: QuantityTerm, right: QuantityTerm, symbol: str) -> tuple[Unit | None, bool]:
    """The unit of a product or quotient, and whether it is exact: a plain factor may have a unit of its own."""
    exact = left.exact and right.exact and "number" not in (left.origin, right.origin)
    units = [NO_UNIT if side.origin == "number" else side.unit for side in (left, right)]
    if left.origin == right.origin == "number" or units[0] is None or units[1] is None:
        return None, exact
    if right.origin == "number":
        return units[0], exact
    if left.origin == "number" and symbol == "*":
        return units[1], exact
    return units[0].times(units[1], 1 if symbol == "*" else -1), exact
