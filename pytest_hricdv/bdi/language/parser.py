"""Reads AgentSpeak text into syntax trees.

lark is imported, and the tables of the grammar are loaded, only when something is parsed for the first time:
a test session without a BDI model does not need them.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_hricdv.bdi.language.errors import BdiError, BdiSyntaxError, Location
from pytest_hricdv.bdi.language.syntax import Include, InitialGoal, Plan, Program, Rule, Trigger
from pytest_hricdv.bdi.language.terms import Structure, Term
from pytest_hricdv.grammar import lark_parser

if TYPE_CHECKING:
    from lark import Lark

    from pytest_hricdv.bdi.language.transformer import AgentSpeakTransformer

MAX_SOURCE = 1_000_000
"""Greatest size of a source file, in bytes: a hundred times that of a large model. A longer text takes minutes."""


def parse_program(text: str, file: str = "<text>") -> Program:
    """Parse the source of one agent.

    Args:
        text: AgentSpeak source.
        file: its name for error messages.

    Raises:
        BdiSyntaxError: with the place of the first token that cannot be parsed.
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


def read_program(path: Path, named_at: Location | None = None, naming_text: str = "") -> Program:
    """Read and parse a source file.

    Args:
        path: the file.
        named_at: where a project or another program names the file, for the error when it is missing.
        naming_text: the text of that project or program.

    Raises:
        BdiError: the file cannot be read, or has a syntax error.
    """
    try:
        return parse_program(read_text(path), str(path))
    except FileNotFoundError:
        if named_at is None:
            raise BdiError(f"{path}: no such file") from None
        message = f"no such file: {path}"
        raise BdiSyntaxError.at(message, named_at, naming_text) from None
    except RecursionError:
        raise BdiError(f"{path}: files that include each other") from None


def read_text(path: Path) -> str:
    """The text of a UTF-8 file.

    Raises:
        FileNotFoundError: there is no such file.
        BdiError: it is a folder, unreadable, too long, or not UTF-8; the message has the line and the byte.
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
    """Parse a literal such as a percept, ``chosen(leg1)``; results are cached.

    Raises:
        BdiSyntaxError: the text is not a literal.
    """
    literal = parse_term(text)
    if not isinstance(literal, Structure):
        raise BdiSyntaxError.at(f"expected a literal, found {literal}", Location("<literal>", 1, 1), text)
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


def _with_automatic_labels(plans: list[Plan]) -> tuple[Plan, ...]:
    """Number the plans without a label; a label that begins with ``_`` cannot be written by an author."""
    return tuple(
        plan if plan.has_label else replace(plan, label=f"_plan{number}") for number, plan in enumerate(plans, start=1)
    )


def _parse(text: str, file: str, start: str) -> Any:
    from lark.exceptions import UnexpectedInput, VisitError

    from pytest_hricdv.bdi.language.syntax_errors import TooDeepError, syntax_error

    lark, transformer = _grammar()
    transformer.begin(text, file)
    try:
        return transformer.transform(lark.parse(text, start=start))
    except VisitError as error:
        raise error.orig_exc from None
    except (UnexpectedInput, TooDeepError) as error:
        raise syntax_error(error, text, file) from None


@lru_cache(maxsize=1)
def _grammar() -> tuple[Lark, AgentSpeakTransformer]:
    from pytest_hricdv.bdi.language.syntax_errors import DepthLimit
    from pytest_hricdv.bdi.language.transformer import AgentSpeakTransformer

    parser = lark_parser(
        Path(__file__).parent / "agentspeak.lark",
        start=["start", "one_term", "one_trigger", "one_plan"],
        propagate_positions=True,
        maybe_placeholders=True,
        postlex=DepthLimit(),
    )
    return parser, AgentSpeakTransformer()
