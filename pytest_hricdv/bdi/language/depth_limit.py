"""A limit on the nesting depth of a source text."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lark import Token

MAX_DEPTH = 120
"""Maximum depth of nested brackets and operators: more than any model has, and safe for Python's stack."""

_OPENING = frozenset({"LPAR", "LSQB", "LBRACE"})
_CLOSING = frozenset({"RPAR", "RSQB", "RBRACE"})
_NESTING_OPERATORS = frozenset({"MINUS", "PLUS", "STAR", "SLASH", "DIV", "MOD", "POWER", "NOT", "ELIF", "ELSE"})
_CHAIN_ENDS = frozenset({"_DOT", "SEMICOLON", "COMMA"})


class DepthLimit:
    """A lark postlexer that refuses text nested so deeply that parsing it would exhaust Python's stack."""

    always_accept = ()

    def process(self, stream: Iterator[Token]) -> Iterator[Token]:
        chains = [0]
        depth = 0
        for token in stream:
            kind = token.type
            if kind in _OPENING:
                chains.append(0)
                depth += 1
            elif kind in _CLOSING and len(chains) > 1:
                depth -= chains.pop() + 1
            elif kind in _NESTING_OPERATORS:
                chains[-1] += 1
                depth += 1
            elif kind in _CHAIN_ENDS:
                depth -= chains[-1]
                chains[-1] = 0
            if depth > MAX_DEPTH:
                raise TooDeepError(token)
            yield token


class TooDeepError(Exception):
    """The nesting depth is exceeded at this token."""

    def __init__(self, token: Token) -> None:
        super().__init__(token)
        self.token = token
