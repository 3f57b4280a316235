"""Content filters: which messages of a topic a subscription receives, in the language of DDS 1.4, annex B."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from lark import Lark, Token, Transformer, UnexpectedCharacters, UnexpectedInput, v_args
from lark.exceptions import VisitError

from pytest_hricdv.extra.ros2.handles import RCLError

Filter = Callable[[Any], bool]
_Operand = Callable[[Any], Any]

_GRAMMAR = r"""
?condition: conjunction | conjunction ("OR"i conjunction)+ -> any_of
?conjunction: predicate | predicate ("AND"i predicate)+ -> all_of
?predicate: "(" condition ")" | "NOT"i predicate -> negate
  | operand (COMPARISON | LIKE | MATCH) operand -> compare
  | operand "BETWEEN"i operand "AND"i operand -> between
  | operand "NOT"i "BETWEEN"i operand "AND"i operand -> outside
operand: PARAMETER -> parameter | FIELD -> field | NUMBER -> number | STRING -> string | TRUE -> true | FALSE -> false
COMPARISON: "=" | "<>" | "!=" | "<" | "<=" | ">" | ">="
LIKE: "LIKE"i
MATCH: "MATCH"i
TRUE: "TRUE"i
FALSE: "FALSE"i
PARAMETER: /%\d+/
FIELD: /[a-z_][\w.\[\]]*/i
NUMBER: /[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?/i
STRING: /'([^'\\]|\\.)*'/
%ignore /\s+/
"""
_COMPARISONS: dict[str, Callable[[Any, Any], Any]] = {
    "=": operator.eq,
    "<>": operator.ne,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "LIKE": lambda value, pattern: _like(pattern).fullmatch(value) is not None,
    "MATCH": lambda value, pattern: re.fullmatch(pattern, value) is not None,
}


@cache
def _parser() -> Lark:
    return Lark(_GRAMMAR, parser="lalr", start=["condition", "operand"])


def _like(pattern: str) -> re.Pattern[str]:
    """`%` matches any text, `_` one character."""
    return re.compile("".join({"%": ".*", "_": "."}.get(char, re.escape(char)) for char in pattern), re.DOTALL)


def content_filter(expression: str, parameters: Sequence[str]) -> Filter:
    """Whether a message passes.

    Args:
        expression: such as "data LIKE %0 AND header.stamp.sec > 3".
        parameters: of `%0` and so on, as they are written in an expression: strings in quotes.

    Raises:
        RCLError: it is not a filter expression.
    """
    message = f"failed to set content filter: {expression!r} is not a filter expression"
    try:
        passes: Filter = _Evaluation(parameters).transform(_parser().parse(expression, start="condition"))
    except UnexpectedInput as error:
        is_end = not isinstance(error, UnexpectedCharacters) and getattr(error, "token", Token("$END", "")) == ""
        raise RCLError(f"{message}, at {'its end' if is_end else repr(expression[error.pos_in_stream :])}") from None
    except VisitError as error:
        raise RCLError(f"{message}: {error.orig_exc}") from None
    return passes


@v_args(inline=True)
class _Evaluation(Transformer[Token, Any]):
    """Makes a function of a message from a syntax tree."""

    def __init__(self, parameters: Sequence[str]) -> None:
        super().__init__()
        self._parameters = parameters

    def any_of(self, *parts: Filter) -> Filter:
        return lambda message: any(part(message) for part in parts)

    def all_of(self, *parts: Filter) -> Filter:
        return lambda message: all(part(message) for part in parts)

    def negate(self, part: Filter) -> Filter:
        return lambda message: not part(message)

    def compare(self, left: _Operand, name: Token, right: _Operand) -> Filter:
        function = _COMPARISONS[name.upper()]
        return lambda message: bool(function(left(message), right(message)))

    def between(self, value: _Operand, low: _Operand, high: _Operand) -> Filter:
        return lambda message: low(message) <= value(message) <= high(message)

    def outside(self, value: _Operand, low: _Operand, high: _Operand) -> Filter:
        return lambda message: not low(message) <= value(message) <= high(message)

    def parameter(self, name: Token) -> Any:
        try:
            text = self._parameters[int(name[1:])]
            return self.transform(_parser().parse(text, start="operand"))
        except IndexError:
            raise ValueError(f"there is no parameter {name}") from None
        except UnexpectedInput:
            raise ValueError(f"its parameter {name}, {text!r}, is not a value") from None

    def field(self, path: Token) -> _Operand:
        steps = re.findall(r"[^.\[\]]+", path)

        def value(message: Any) -> Any:
            for step in steps:
                message = message[int(step)] if step.isdigit() else getattr(message, step)
            return message

        return value

    def number(self, text: Token) -> _Operand:
        number = float(text)
        return lambda message: number

    def string(self, quoted: Token) -> _Operand:
        text = re.sub(r"\\(.)", r"\1", quoted[1:-1])
        return lambda message: text

    def true(self, _: Token) -> _Operand:
        return lambda message: 1.0

    def false(self, _: Token) -> _Operand:
        return lambda message: 0.0
