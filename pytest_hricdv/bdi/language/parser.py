"""From AgentSpeak text to syntax trees.

lark is imported, and the grammar's tables are loaded, only when something is parsed for the first time:
a test session that uses no BDI model does not need them.
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_hricdv.bdi.language.depth_limit import MAX_NESTING, NestingError, NestingLimit
from pytest_hricdv.bdi.language.errors import BdiError, BdiSyntaxError, Location
from pytest_hricdv.bdi.language.syntax import Plan, Program, Rule, Trigger
from pytest_hricdv.bdi.language.terms import Structure, Term
from pytest_hricdv.grammar import lark_parser

if TYPE_CHECKING:
    from lark import Lark, Token
    from lark.exceptions import UnexpectedToken as UnexpectedToken

MAX_SOURCE = 1_000_000
"""Bytes of a file, a hundred times what any model has; more would take minutes to read, and is no model."""

_BRACKETS = {"LPAR": "(", "LSQB": "[", "LBRACE": "{", "BANG": "!", "QMARK": "?"}
_HINTS = {
    "^": "; meta-events such as ^!g are not supported",
    "'": "; strings are in double quotes",
    "%": "; the remainder is 'mod', comments begin with '//'",
    "#": "; comments begin with '//'",
    "begin": "; of directives there is only include",
    "is": "; values are given with '='",
    "and": "; conditions are joined by '&'",
    "or": "; one of several conditions is written with '|'",
}
_PUNCTUATION = {"_DOT": ".", "SEMICOLON": ";", "COMMA": ",", "RPAR": ")", "RSQB": "]", "RBRACE": "}"}


def parse_program(text: str, file: str = "<text>") -> Program:
    """Parse the source of one agent.

    Args:
        text: AgentSpeak source.
        file: its name for error messages.

    Raises:
        BdiSyntaxError: with the place of the first thing that cannot be read.
    """
    items = _parse(text, file, "start")
    beliefs: list[Structure | Rule] = []
    goals: list[Structure] = []
    plans: list[Plan] = []
    for item in items:
        if isinstance(item, Plan):
            plans.append(item)
        elif isinstance(item, Rule):
            beliefs.append(item)
        elif isinstance(item, Include):
            included = read_program(Path(file).parent / item.path, item.location, text)
            beliefs.extend(included.beliefs)
            goals.extend(included.goals)
            plans.extend(included.plans)
        elif isinstance(item, InitialGoal):
            goals.append(item.literal)
        else:
            beliefs.append(item)
    return Program(file, tuple(beliefs), tuple(goals), _with_automatic_labels(plans))


def read_program(path: Path, asked_at: Location | None = None, asking_text: str = "") -> Program:
    """Read and parse a source file.

    Args:
        path: the file.
        asked_at: the place of the project or program text that names the file, for the error when it is missing.
        asking_text: that text.

    Raises:
        BdiError: the file cannot be read, or holds a syntax error.
    """
    try:
        return parse_program(read_text(path), str(path))
    except FileNotFoundError:
        if asked_at is None:
            raise BdiError(f"{path}: no such file") from None
        message = f"no such file: {path}"
        raise BdiSyntaxError.at(message, asked_at.file, asked_at.line, asked_at.column, asking_text) from None
    except RecursionError:
        raise BdiError(f"{path}: files that include each other") from None


def read_text(path: Path) -> str:
    """The text of a UTF-8 file.

    Raises:
        FileNotFoundError: there is no such file.
        BdiError: it is a folder, unreadable, or not UTF-8; the message says which byte of which line.
    """
    try:
        size = path.stat().st_size
        data = path.read_bytes() if size <= MAX_SOURCE else b""
    except FileNotFoundError:
        raise
    except (OSError, ValueError) as error:
        raise BdiError(f"{path}: cannot be read: {getattr(error, 'strerror', error)}") from None
    if size > MAX_SOURCE:
        message = f"too long to be a model: {size:,} bytes, more than {MAX_SOURCE:,}"
        raise BdiSyntaxError(message, str(path), 1, 1)
    try:
        return data.decode("utf-8").removeprefix("\ufeff")
    except UnicodeDecodeError as error:
        before = data[: error.start]
        line, column = before.count(b"\n") + 1, error.start - (before.rfind(b"\n") + 1) + 1
        raise BdiSyntaxError(f"not UTF-8 text: byte 0x{data[error.start]:02x}", str(path), line, column) from None


def parse_term(text: str) -> Term:
    """Parse one term.

    Raises:
        BdiSyntaxError: the text is not a term.
    """
    term: Term = _parse(text, "<term>", "one_term")
    return term


@lru_cache(maxsize=4096)
def parse_literal(text: str) -> Structure:
    """Parse a literal such as a percept, ``chosen(leg1)``; what was parsed before is remembered.

    Raises:
        BdiSyntaxError: the text is not a literal.
    """
    literal = parse_term(text)
    if not isinstance(literal, Structure):
        raise BdiSyntaxError.at(f"expected a literal, found {literal}", "<literal>", 1, 1, text)
    return literal


def parse_trigger(text: str) -> Trigger:
    """Parse a triggering event such as ``+done(X)``.

    Raises:
        BdiSyntaxError: the text is not a triggering event.
    """
    trigger: Trigger = _parse(text, "<event>", "one_trigger")
    return trigger


def parse_plan(text: str) -> Plan:
    """Parse a plan, with or without its final full stop.

    Raises:
        BdiSyntaxError: the text is not a plan.
    """
    plan: Plan = _parse(text, "<plan>", "one_plan")
    return plan


class Include:
    """``{ include("file.asl") }``."""

    def __init__(self, path: str, location: Location) -> None:
        self.path = path
        self.location = location


class InitialGoal:
    """``!g.`` at the top level."""

    def __init__(self, literal: Structure) -> None:
        self.literal = literal


def _with_automatic_labels(plans: list[Plan]) -> tuple[Plan, ...]:
    """Number the plans without a label; a label that begins with ``_`` cannot be written by an author."""
    from dataclasses import replace

    return tuple(
        plan if plan.has_label else replace(plan, label=f"_plan{number}") for number, plan in enumerate(plans, start=1)
    )


def _parse(text: str, file: str, start: str) -> Any:
    from lark.exceptions import UnexpectedCharacters, UnexpectedToken, VisitError

    lark, builder = _grammar()
    builder.begin(text, file)
    try:
        return builder.transform(lark.parse(text, start=start))
    except VisitError as error:
        raise error.orig_exc from None
    except UnexpectedToken as error:
        line, column = _place(error.token, text)
        message = _unexpected(error, text)
        if _starts_plan(error.token, text):
            column -= 1
        raise BdiSyntaxError.at(message, file, line, column, text) from None
    except UnexpectedCharacters as error:
        message = _bad_character(text, error.pos_in_stream or 0)
        raise BdiSyntaxError.at(message, file, error.line, error.column, text) from None
    except NestingError as error:
        line, column = _place(error.token, text)
        message = f"nested too deeply: more than {MAX_NESTING} brackets and operators in each other"
        raise BdiSyntaxError.at(message, file, line, column, text) from None


def _place(token: Token, text: str) -> tuple[int, int]:
    if token.type != "$END":
        return token.line or 1, token.column or 1
    stripped = text.rstrip()
    return stripped.count("\n") + 1, len(stripped) - (stripped.rfind("\n") + 1) + 1


def _unexpected(error: UnexpectedToken, text: str) -> str:
    token = error.token
    if token.type == "$END":
        return f"expected {_expectation(error.accepts)}, found the end of the file"
    if text.startswith("/*", token.start_pos):
        return "a comment that is not closed"
    if _starts_plan(token, text):
        return f"expected '.' before the next plan, found '{text[(token.start_pos or 1) - 1]}{token}'"
    return f"expected {_expectation(error.accepts)}, found '{token}'{_hint(token, error.accepts, text)}"


def _hint(token: Token, accepted: set[str], text: str) -> str:
    """What to write instead of what other languages have."""
    in_body = "SEMICOLON" in accepted
    if token.type == "COMMA" and not accepted & {"RPAR", "RSQB"}:
        return "; statements are separated by ';'" if in_body else "; conditions are joined by '&'"
    if token.type == "INTERNAL" and "_DOT" in accepted and not in_body:
        return "; a full stop needs a space after it"
    if token.type == "BANG" and text.startswith("!=", token.start_pos):
        return "; unequal is '\\=='"
    return _HINTS.get(str(token), "")


def _starts_plan(token: Token, text: str) -> bool:
    """Whether a plan begins where an operand was expected: ``b +!g`` reads as a sum, but lacks a full stop."""
    position = token.start_pos or 0
    return str(token) in ("!", "?") and position > 0 and text[position - 1] in "+-"


def _expectation(accepted: set[str]) -> str:
    """What could have come, in the reader's words: the punctuation if any, else the kind of thing."""
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
    return f"unexpected character {character!r}{_HINTS.get(character, '')}"


@lru_cache(maxsize=1)
def _grammar() -> tuple[Lark, Any]:
    from pytest_hricdv.bdi.language.transformer import TreeBuilder

    parser = lark_parser(
        Path(__file__).parent / "agentspeak.lark",
        start=["start", "one_term", "one_trigger", "one_plan"],
        propagate_positions=True,
        maybe_placeholders=True,
        postlex=NestingLimit(),
    )
    return parser, TreeBuilder()
