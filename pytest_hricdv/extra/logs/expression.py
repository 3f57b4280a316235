"""Arithmetic expressions over the fields of a logged message, such as `hypot(speed.x, speed.y)`.

`log_map` calls `parse_expression` for the map of a log, which says how its messages become those of a testbench.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache

from pytest_hricdv._base.message import InputError, nearest, quote
from pytest_hricdv.recordings.bags import Value

FUNCTIONS: Mapping[str, Callable[..., float]] = {
    "abs": abs, "min": min, "max": max, "sqrt": math.sqrt, "hypot": math.hypot, "atan2": math.atan2,
}  # fmt: skip
_OPERATORS: Mapping[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
}
MAX_CHARACTERS = 1000
"""Maximum length of an expression, in characters, which also limits its depth."""

_Part = Callable[[Mapping[str, float]], float]


@dataclass(frozen=True)
class Expression:
    """A parsed expression.

    Args:
        text: the source.
        names: the fields that it reads, as dotted paths.
        problem: the syntax error; empty if it is valid.
    """

    text: str
    names: tuple[str, ...]
    problem: str
    _compute: _Part

    def problems(self, name: str) -> Iterator[str]:
        """The message about its problem, if it has one, under the name of the signal or field that it computes."""
        if self.problem:
            yield f"{name}: expression {quote(self.text)}: {self.problem}"

    def value(self, name: str, fields: Mapping[str, Value]) -> float:
        """Its value for the fields of a message. Raises InputError if a field or the value is not a number."""
        numbers = {}
        for path in self.names:
            number = fields.get(path)
            if type(number) is not float:
                at = (
                    "its messages have no field " + path + nearest(path, fields)
                    if number is None
                    else f"{path} is not one"
                )
                raise InputError(f"{name}: expression {quote(self.text)}: expected numbers; {at}")
            numbers[path] = number
        try:
            return float(self._compute(numbers))
        except (ArithmeticError, ValueError, TypeError) as error:
            raise InputError(f"{name}: expression {quote(self.text)}: {error}") from None


@cache
def parse_expression(text: str) -> Expression:
    """Parse an expression, without raising and without executing anything in it."""
    names: dict[str, None] = {}
    problem, part = "", _constant(math.nan)
    try:
        if len(text) > MAX_CHARACTERS:
            raise SyntaxError(f"has more than {MAX_CHARACTERS:,} characters")
        part = _part(ast.parse(text.strip(), mode="eval").body, names)
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        problem = getattr(error, "msg", None) or str(error)
    return Expression(text, tuple(names), problem, part)


def _constant(value: float) -> _Part:
    return lambda numbers: value


def _part(node: ast.expr, names: dict[str, None]) -> _Part:
    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            return _constant(float(value))
        case ast.Name() | ast.Attribute():
            path = _path(node)
            names[path] = None
            return lambda numbers: numbers[path]
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            inner = _part(operand, names)
            return lambda numbers: -inner(numbers)
        case ast.BinOp(left=left, op=operator, right=right) if type(operator) in _OPERATORS:
            first, second, compute = _part(left, names), _part(right, names), _OPERATORS[type(operator)]
            return lambda numbers: compute(first(numbers), second(numbers))
        case ast.Call(func=ast.Name(id=function), args=arguments, keywords=[]) if function in FUNCTIONS and arguments:
            parts, apply = [_part(argument, names) for argument in arguments], FUNCTIONS[function]
            return lambda numbers: apply(*(part(numbers) for part in parts))
        case _:
            raise SyntaxError(f"expected fields, numbers, + - * / and {', '.join(FUNCTIONS)}")


def _path(node: ast.expr) -> str:
    match node:
        case ast.Name(id=name):
            return name
        case ast.Attribute(value=value, attr=name):
            return f"{_path(value)}.{name}"
        case _:
            raise SyntaxError("expected a field, such as pose.position.x")
