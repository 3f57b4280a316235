"""Filters of the content of a topic: which messages a subscription wants, in the language of DDS 1.4, annex B."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Sequence
from typing import Any

from pytest_hricdv.extra.ros2.handles import RCLError

Filter = Callable[[Any], bool]
_Operand = Callable[[Any], Any]

_TOKEN = re.compile(
    r"\s*(?:(?P<text>'(?:[^'\\]|\\.)*')|(?P<number>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<parameter>%\d+)"
    r"|(?P<operator><>|!=|<=|>=|=|<|>)|(?P<word>[A-Za-z_][\w.\[\]]*)|(?P<bracket>[()]))"
)
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


def _like(pattern: str) -> re.Pattern[str]:
    """`%` stands for any text, `_` for one character."""
    return re.compile("".join({"%": ".*", "_": "."}.get(char, re.escape(char)) for char in pattern), re.DOTALL)


def content_filter(expression: str, parameters: Sequence[str]) -> Filter:
    """Whether a message passes.

    Args:
        expression: such as "data LIKE %0 AND header.stamp.sec > 3".
        parameters: of `%0` and so on, as they are written in an expression: texts in quotes.

    Raises:
        RCLError: it is none.
    """
    parser = _Parser(expression, parameters)
    passes = parser.condition()
    parser.require_end()
    return passes


class _Parser:
    def __init__(self, expression: str, parameters: Sequence[str]) -> None:
        self._expression, self._parameters = expression, parameters
        self._tokens = self._split(expression)

    def _split(self, text: str) -> list[tuple[str, str]]:
        tokens, position, end = [], 0, len(text.rstrip())
        while position < end:
            match = _TOKEN.match(text, position)
            if match is None:
                raise self._fault(f"{text[position:]!r}")
            tokens.append((str(match.lastgroup), match[str(match.lastgroup)]))
            position = match.end()
        return tokens

    def _fault(self, problem: str) -> RCLError:
        return RCLError(f"failed to set content filter: {self._expression!r} is no filter expression, at {problem}")

    def _next(self) -> tuple[str, str]:
        if not self._tokens:
            raise self._fault("its end")
        return self._tokens.pop(0)

    def _takes(self, *words: str) -> str:
        """Take the next token if it is one of these."""
        if self._tokens and self._tokens[0][1].upper() in words:
            return self._next()[1].upper()
        return ""

    def require_end(self) -> None:
        if self._tokens:
            raise self._fault(repr(self._tokens[0][1]))

    def condition(self) -> Filter:
        """Of conditions, any."""
        parts = [self._all_of()]
        while self._takes("OR"):
            parts.append(self._all_of())
        return parts[0] if len(parts) == 1 else lambda message: any(part(message) for part in parts)

    def _all_of(self) -> Filter:
        parts = [self._negation()]
        while self._takes("AND"):
            parts.append(self._negation())
        return parts[0] if len(parts) == 1 else lambda message: all(part(message) for part in parts)

    def _negation(self) -> Filter:
        if self._takes("NOT"):
            negated = self._negation()
            return lambda message: not negated(message)
        if self._takes("("):
            inner = self.condition()
            if not self._takes(")"):
                raise self._fault("a bracket that is not closed")
            return inner
        return self._predicate()

    def _predicate(self) -> Filter:
        left, is_negated = self._operand(), bool(self._takes("NOT"))
        if self._takes("BETWEEN"):
            least = self._operand()
            if not self._takes("AND"):
                raise self._fault("BETWEEN without AND")
            most = self._operand()
            return lambda message: (least(message) <= left(message) <= most(message)) != is_negated
        name = self._takes(*_COMPARISONS)
        if not name or is_negated:
            raise self._fault(repr(name or self._tokens[0][1]) if name or self._tokens else "its end")
        compare, right = _COMPARISONS[name], self._operand()
        return lambda message: bool(compare(left(message), right(message)))

    def _operand(self) -> _Operand:
        kind, text = self._next()
        if kind == "parameter":
            if int(text[1:]) >= len(self._parameters):
                raise self._fault(f"{text}, of which there is no parameter")
            written = self._split(self._parameters[int(text[1:])])
            if len(written) != 1:
                raise self._fault(f"its parameter {text}, {self._parameters[int(text[1:])]!r}")
            kind, text = written[0]
        if kind == "word" and text.upper() in ("TRUE", "FALSE"):
            kind, text = "number", str(int(text.upper() == "TRUE"))
        if kind == "word":
            return operator.attrgetter(text) if "[" not in text else _element(text)
        if kind not in ("text", "number"):
            raise self._fault(repr(text))
        value = re.sub(r"\\(.)", r"\1", text[1:-1]) if kind == "text" else float(text)
        return lambda message: value


def _element(path: str) -> _Operand:
    """A field that is, or is in, an element of an array: "points[2].x"."""
    steps = re.findall(r"[^.\[\]]+", path)

    def value(message: Any) -> Any:
        for step in steps:
            message = message[int(step)] if step.isdigit() else getattr(message, step)
        return message

    return value
