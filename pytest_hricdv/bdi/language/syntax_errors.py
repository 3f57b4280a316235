"""`syntax_error` makes the parser's error messages: what was expected, what was found, and what to write instead.

The parser calls it for each error of lark, and has lark refuse text that is nested too deeply (`DepthLimit`).
"""

from __future__ import annotations

from collections.abc import Iterator

from lark import Token
from lark.exceptions import UnexpectedInput, UnexpectedToken

from pytest_hricdv.bdi.language.errors import BdiSyntaxError, Location

MAX_DEPTH = 120
"""Maximum depth of nested brackets and operators: more than any model has, and safe for Python's stack, which the text
or the hash of a term exhausts at 198 structures in each other, 249 lists, 330 negations."""

_OPENING = frozenset({"LPAR", "LSQB", "LBRACE"})
_CLOSING = frozenset({"RPAR", "RSQB", "RBRACE"})
_NESTING_OPERATORS = frozenset({"MINUS", "PLUS", "STAR", "SLASH", "DIV", "MOD", "POWER", "NOT", "ELIF", "ELSE"})
_CHAIN_ENDS = frozenset({"_DOT", "SEMICOLON", "COMMA"})
"""Tokens after which the operators of an expression nest no more."""

_BRACKETS = {"LPAR": "(", "LSQB": "[", "LBRACE": "{", "BANG": "!", "QMARK": "?"}
_HINTS = {
    "^": "; an event of a goal's state is written ^!g[state(S)]",
    "'": "; strings are in double quotes, names with other characters in single quotes, on one line",
    "%": "; the remainder is 'mod', comments begin with '//'",
    "#": "; comments begin with '//'",
    "is": "; values are given with '='",
    "and": "; conditions are joined by '&'",
    "or": "; one of several conditions is written with '|'",
}
_PUNCTUATION = {"_DOT": ".", "SEMICOLON": ";", "COMMA": ",", "RPAR": ")", "RSQB": "]", "RBRACE": "}"}


_STARTS = frozenset({"ATOM", "VARIABLE", "SPACE", "INTERNAL", "BANG", "QMARK", "IF", "FOR", "WHILE"})
"""The tokens that statements begin with; what begins with a sign may be the rest of an expression."""


class DepthLimit:
    """A lark postlexer that refuses text nested so deeply that parsing it would exhaust Python's stack."""

    always_accept = ()

    def process(self, stream: Iterator[Token]) -> Iterator[Token]:
        # The operators since each open bracket: `a + b + c` nests too, but not beyond the end of its term.
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


def syntax_error(error: UnexpectedInput | TooDeepError, text: str, file: str) -> BdiSyntaxError:
    """The error of the parser as an error with a message and its place in the text."""
    if isinstance(error, UnexpectedToken):
        message, (line, column) = _describe_unexpected(error, text), _place(error.token, text)
        if _starts_plan(error.token, text):
            column -= 1
    elif isinstance(error, TooDeepError):
        message = f"nested too deeply: more than {MAX_DEPTH} levels of brackets and operators"
        line, column = _place(error.token, text)
    else:
        message = _bad_character(text, error.pos_in_stream or 0)
        line, column = error.line, error.column
    return BdiSyntaxError.at(message, Location(file, line, column), text)


def _place(token: Token, text: str) -> tuple[int, int]:
    """Line and column of a token; of the end of the file, those behind the last character that is not a space."""
    if token.type != "$END":
        return token.line or 1, token.column or 1
    stripped = text.rstrip()
    return stripped.count("\n") + 1, len(stripped) - (stripped.rfind("\n") + 1) + 1


def _describe_unexpected(error: UnexpectedToken, text: str) -> str:
    token = error.token
    if token.type == "$END":
        return f"expected {_expectation(error.accepts)}, found the end of the file"
    if text.startswith("/*", token.start_pos):
        return "a comment that is not closed"
    if _starts_plan(token, text):
        return f"expected '.' before the next plan, found '{text[(token.start_pos or 1) - 1]}{token}'"
    return f"expected {_expectation(error.accepts)}, found '{token}'{_hint(token, error.accepts, text)}"


def _hint(token: Token, accepted: set[str], text: str) -> str:
    """The AgentSpeak form of what other languages write differently, as the end of the message."""
    in_body = "SEMICOLON" in accepted
    if token.type == "COMMA" and not accepted & {"RPAR", "RSQB"}:
        return "; statements are separated by ';'" if in_body else "; conditions are joined by '&'"
    if token.type == "INTERNAL" and "_DOT" in accepted and not in_body:
        return "; a full stop needs a space after it"
    if text.startswith(("|&|", "|||"), token.start_pos or 0):
        return "; statements side by side are single ones, joined by '|&|' alone or '|||' alone, with no blocks"
    if token.type == "BANG" and text.startswith("!=", token.start_pos):
        return "; unequal is '\\=='"
    if in_body and str(token) not in _HINTS and token.type in _STARTS:
        return "; a ';' is missing between two statements"
    return _HINTS.get(str(token), "")


def _starts_plan(token: Token, text: str) -> bool:
    """Whether a plan begins where an operand was expected: in ``b +!g`` a full stop is missing; ``b +`` is no sum."""
    position = token.start_pos or 0
    return str(token) in ("!", "?") and position > 0 and text[position - 1] in "+-"


def _expectation(accepted: set[str]) -> str:
    """The input that the parser would accept: punctuation if any, else the kind of construct."""
    if {"BANG", "INTERNAL"} <= accepted and "SEMICOLON" not in accepted:
        return "a statement"
    signs = [f"'{sign}'" for name, sign in _PUNCTUATION.items() if name in accepted]
    if signs:
        return " or ".join(signs)
    if "STRING" in accepted and "BANG" not in accepted:
        return "a term or condition" if "NOT" in accepted else "a term"
    if "BANG" in accepted and "AT" in accepted:
        return "a belief, goal or plan"
    if "ATOM" in accepted:
        return "a literal"
    if {"PLUS", "MINUS"} <= accepted:
        return "an event such as +!g or -b"
    return " or ".join(sorted(f"'{_BRACKETS.get(name, name.lower())}'" for name in accepted if name[:2] != "__"))


def _bad_character(text: str, position: int) -> str:
    character = text[position]
    if character == '"':
        return "a string that is not closed"
    if text.startswith("/*", position):
        return "a comment that is not closed"
    hint = _HINTS.get(character, "")
    return f"unexpected character {character!r}{hint}"
