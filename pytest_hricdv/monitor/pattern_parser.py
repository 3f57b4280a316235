"""Parses patterns such as `response(on(request), on(leg_ready), within_s=30)`: arguments are conditions and numbers.

`parse_pattern` does so for one text. `RequirementParser` parses formulas, too: the functions of `loading` use it, and
import it late, since it needs lark.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator, Mapping
from typing import cast

from lark import Token, Tree

from pytest_hricdv._base.message import nearest, quote
from pytest_hricdv.monitor.dsl import NumberValue, TruthValue
from pytest_hricdv.monitor.formula import Formula
from pytest_hricdv.monitor.node import Term
from pytest_hricdv.monitor.parser import FormulaParser
from pytest_hricdv.monitor.past_formula import On
from pytest_hricdv.monitor.patterns import PATTERNS, SOURCE_NEEDED, PatternError
from pytest_hricdv.monitor.patterns.pattern import argument_types
from pytest_hricdv.monitor.requirement import FormulaSource
from pytest_hricdv.monitor.syntax_tree import syntax_tree
from pytest_hricdv.monitor.term_parser import Node
from pytest_hricdv.monitor.terms import Negative, NumberTerm
from pytest_hricdv.monitor.units import NO_UNIT, QuantityTerm, unit_of
from pytest_hricdv.monitor.vocabulary import Vocabulary

__all__ = ["parse_pattern"]

# The ends of parameter names -> the unit of the argument, the longest first. A speed has the unit of its signal.
_UNITS = {"_n_cm2": "N/cm^2", "_n": "N", "_m": "m", "_s": "s", "distance": "m", "force": "N", "pressure": "N/cm^2"}
_SPEEDS = ("slow_speed", "standstill")

Parameters = Mapping[str, inspect.Parameter]


def parse_pattern(source: FormulaSource, vocabulary: Vocabulary, *, has_source: bool = True) -> Formula:
    """The formula of a pattern.

    Args:
        source: the source of the text.
        vocabulary: the names that it may use.
        has_source: whether the requirement says where its limits come from.

    Raises:
        RequirementError: the text is not a pattern, an argument is unknown, missing or wrong, or a limit has no source;
            the caret marks the place.
    """
    return RequirementParser(source, vocabulary).pattern(has_source=has_source)


class RequirementParser(FormulaParser):
    """The parser of all texts in requirements, also of patterns: it makes their arguments as their parameters say."""

    def pattern(self, *, has_source: bool) -> Formula:
        """The formula of a pattern."""
        tree = syntax_tree(self._source, "pattern")
        name = cast("Token", tree.children[0])
        if name not in PATTERNS:
            raise self._error(name, f"unknown pattern {quote(str(name))}{nearest(name, PATTERNS)}")
        if name in SOURCE_NEEDED and not has_source:
            advice = 'expected the key source, which says where the limit comes from: source = "..."'
            raise self._error(name, f"{name} has a limit, and the requirement no source", advice)
        # The signature says what the arguments are, so that a new pattern needs no entry here.
        parameters = inspect.signature(PATTERNS[name], eval_str=True).parameters
        nodes = dict(
            self._nodes(name, parameters, [argument for argument in tree.children[1:] if argument is not None])
        )
        for parameter in parameters.values():
            if parameter.default is inspect.Parameter.empty and parameter.name not in nodes:
                raise self._error(name, f"{name} needs {parameter.name}", _usage(name, parameters))
        arguments = {argument: self._argument(parameters[argument], nodes) for argument in nodes}
        try:
            return PATTERNS[name](**arguments)
        except PatternError as error:
            raise self._error(nodes.get(error.argument, name), str(error)) from None

    def _nodes(self, name: Token, parameters: Parameters, arguments: list[Node]) -> Iterator[tuple[str, Node]]:
        """Name and syntax tree of each argument."""
        positional = [
            parameter.name for parameter in parameters.values() if parameter.kind is not inspect.Parameter.KEYWORD_ONLY
        ]
        seen: set[str] = set()
        for index, argument in enumerate(cast("list[Tree[Token]]", arguments)):
            keyword, node = argument.children  # the keyword is None if there is none
            if keyword is None and index >= len(positional):
                raise self._error(
                    node, f"{name} takes {len(positional)} arguments by position", _usage(name, parameters)
                )
            parameter = positional[index] if keyword is None else str(keyword)
            if parameter not in parameters:
                problem = f"{name} has no argument {parameter!r}{nearest(parameter, parameters)}"
                raise self._error(keyword, problem, _usage(name, parameters))
            if parameter in seen:
                raise self._error(keyword or node, f"{parameter} is given twice")
            seen.add(parameter)
            yield parameter, node

    def _argument(self, parameter: inspect.Parameter, nodes: Mapping[str, Node]) -> TruthValue | NumberValue | float:
        types, node = argument_types(parameter), nodes[parameter.name]
        if TruthValue in types:
            return TruthValue(self._topic(node) or self._past(node))
        term = self._in_unit_of_parameter(parameter.name, nodes).term
        value = _number(term)
        if value is None and NumberValue in types:
            return NumberValue(term)
        if value is None or (NumberValue in types and float not in types):
            expected = "a signal or a field" if value is not None else "a number, without signals and fields"
            raise self._error(node, f"{parameter.name}: expected {expected}")
        return int(value) if int in types and value.is_integer() else value

    def _in_unit_of_parameter(self, name: str, nodes: Mapping[str, Node]) -> QuantityTerm:
        """A number in the unit of its parameter: a quantity is converted, a signal in another unit is an error."""
        node, number = nodes[name], self._operand(nodes[name])
        if name == "speed":
            return number
        if name in _SPEEDS:
            return self._in_one_unit(nodes["speed"], self._operand(nodes["speed"]), node, number)[1]
        unit = next((unit_of(unit) for end, unit in _UNITS.items() if name.endswith(end)), NO_UNIT)
        return self._in_one_unit(node, QuantityTerm(NumberTerm(0.0), unit, "value"), node, number)[1]

    def _topic(self, node: Node) -> On | None:
        """The arrival of a message, for a topic alone: as an argument it cannot mean anything else."""
        tree = cast("Tree[Token]", node)
        name = str(tree.children[0])
        if tree.data != "name" or self._vocabulary.kind(name) is not None:
            return None
        if name not in self._vocabulary.messages:
            names = [*self._vocabulary.names(), *self._vocabulary.messages]
            raise self._error(tree, f"unknown name {quote(name)}{nearest(name, names)}")
        return On(name)


def _number(term: Term) -> float | None:
    """The value of a number; None if signals or fields decide it."""
    match term:
        case NumberTerm():
            return term.value
        case Negative(operand=NumberTerm(value=value)):
            return -value
        case _:
            return None


def _usage(name: str, parameters: Parameters) -> str:
    """How a pattern is written: arguments by position, then by name, those that may be left out in brackets."""
    texts = []
    for parameter in parameters.values():
        text = f"{parameter.name}=..." if parameter.kind is inspect.Parameter.KEYWORD_ONLY else parameter.name
        texts.append(text if parameter.default is inspect.Parameter.empty else f"[{text}]")
    return f"expected {name}({', '.join(texts)})"
