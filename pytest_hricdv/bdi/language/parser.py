"""Parses AgentSpeak: `read_program` a source file, `parse_literal`, `parse_plan` and others a text.

`MultiAgentSystem` and lint read programs; environments, internal actions and the coupling with robots parse texts.
lark is imported, and the tables of the grammar are loaded, only when something is parsed for the first time:
a test session without a BDI model does not need them.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pytest_hricdv._base import input_file
from pytest_hricdv._base.grammar import lark_parser
from pytest_hricdv._base.input_file import EncodingError, MalformedError
from pytest_hricdv.bdi.language import namespaces
from pytest_hricdv.bdi.language.errors import BdiError, BdiSyntaxError, Location
from pytest_hricdv.bdi.language.syntax import Include, InitialGoal, Plan, PlanTrigger, Program, Rule
from pytest_hricdv.bdi.language.terms import Structure, Term

if TYPE_CHECKING:
    from lark import Lark

    from pytest_hricdv.bdi.language.transformer import AgentSpeakTransformer

MAX_SOURCE = 1_000_000
"""Greatest size (bytes) of a program with all files that it includes, and of a project file: seventy times the size of
the table example's four agents. 100 kB of plans are parsed in 2.4 s, 1 MB in 41 s, a longer text would take minutes."""

MAX_FILES = 1_000
"""Most files that a program consists of, each as often as it is included (chosen): thirty files of which each includes
the next twice would be a billion."""

MAX_INCLUDE_DEPTH = 50
"""Most files in a chain of includes: each takes two of the 1,000 frames of Python's stack."""


def parse_program(text: str, file: str = "<text>") -> Program:
    """Parse the source of one agent.

    Args:
        text: AgentSpeak source.
        file: its name for error messages.

    Raises:
        BdiSyntaxError: with the place of the first token that cannot be parsed.
    """
    return _ProgramReader().parse(text, file)


def read_program(path: Path, named_at: Location | None = None, naming_text: str = "") -> Program:
    """Read and parse a source file.

    Args:
        named_at: where a project or another program names the file, for the error when it is missing.
        naming_text: the text of that project or program.

    Raises:
        BdiError: the file cannot be read, or has a syntax error.
    """
    return _ProgramReader().read(path, named_at, naming_text)


@dataclass(frozen=True, slots=True)
class SourceText:
    """The text of a source or project file.

    Args:
        text: the text, with plain line ends.
        not_utf8: the place of the first byte that is not UTF-8, where the text was read as Latin-1; else empty.
    """

    text: str
    not_utf8: str = ""


def read_source(path: Path) -> SourceText:
    """Read a source or project file, if it is not UTF-8 as Latin-1, in which any bytes are text.

    Raises:
        FileNotFoundError: there is no such file.
        BdiError: it is not a regular file, unreadable, or too large.
    """
    try:
        data = input_file.read_bytes(path, MAX_SOURCE)
    except MalformedError as error:
        raise BdiError(f"{path}{error}") from None
    try:
        return SourceText(input_file.decode_text(data))
    except EncodingError as error:
        return SourceText(input_file.with_plain_ends(data.decode("latin-1")), f"{path}{error}")


def with_encoding(error: BdiSyntaxError, source: SourceText) -> BdiSyntaxError:
    """An error in a source which also says that this is not UTF-8, where it is so: that may be the cause."""
    if not source.not_utf8:
        return error
    message = f"{error.message}; the file is read as Latin-1: {source.not_utf8}"
    return BdiSyntaxError(message, error.file, error.line, error.column, error.source_line)


class _ProgramReader:
    """Reads one program: a source, and all that it includes, directly or not."""

    def __init__(self) -> None:
        self._local_spaces = count(1)
        self._open: list[Path] = []
        """The file that is being read, behind those that led to it."""
        self._files = 0
        self._size = 0

    def read(self, path: Path, named_at: Location | None, naming_text: str, space: str = namespaces.DEFAULT) -> Program:
        """See `read_program`; ``space`` is the namespace of what has none."""
        try:
            source = read_source(path)
            self._check(path, source.text, named_at, naming_text)
            self._open.append(_real(path))
            program = self.parse_file(path, source, space)
            self._open.pop()
            return program
        except FileNotFoundError:
            if named_at is None:
                raise BdiError(f"{path}: no such file") from None
            raise BdiSyntaxError.at(f"no such file: {path}", named_at, naming_text) from None
        except BdiError as error:
            if named_at is None or _is_within(path, Path(named_at.file).parent):
                raise
            raise BdiSyntaxError.at(_without_contents(error, path), named_at, naming_text) from None

    def parse_file(self, path: Path, source: SourceText, space: str = namespaces.DEFAULT) -> Program:
        """Parse the text of a file; an error in one that is not UTF-8 says so, too."""
        if not source.not_utf8:
            return self.parse(source.text, str(path), space)
        try:
            program = self.parse(source.text, str(path), space)
        except BdiSyntaxError as error:
            raise with_encoding(error, source) from None
        return replace(program, warnings=(f"{source.not_utf8}: read as Latin-1", *program.warnings))

    def parse(self, text: str, file: str, space: str = namespaces.DEFAULT) -> Program:
        """See `parse_program`."""
        beliefs: list[Structure | Rule] = []
        goals: list[Structure] = []
        plans: list[Plan] = []
        from pytest_hricdv.bdi.language.plan_patterns import PlanPattern

        items, warnings, last_number = self._items(text, file, space)
        for item in filter(None, items):
            if isinstance(item, Plan):
                plans.append(item)
            elif isinstance(item, PlanPattern):
                plans.extend(item.plans)
                beliefs.extend(item.beliefs)
            elif isinstance(item, Include):
                inner = item.space or space
                included = self.read(Path(file).parent / item.path, item.location, text, inner)
                beliefs.extend(included.beliefs)
                goals.extend(included.goals)
                plans.extend(included.plans)
                warnings.extend(included.warnings)
                last_number = max(last_number, included.last_number)
            elif isinstance(item, InitialGoal):
                goals.append(item.literal)
            else:
                beliefs.append(item)
        labelled = _with_automatic_labels(plans)
        return Program(file, tuple(beliefs), tuple(goals), labelled, tuple(warnings), last_number)

    def _items(self, text: str, file: str, space: str) -> tuple[list[Any], list[str], int]:
        """The parts of a source, what its author should know, and the greatest number of a variable ``_n``."""
        items: list[Any] = _parse(text, file, "start")
        _, transformer = _grammar()
        warnings, last_number = transformer.warnings, transformer.last_number
        if space != namespaces.DEFAULT or transformer.has_spaces:
            items = namespaces.in_spaces(items, space, self._local_spaces)
        return items, warnings, last_number

    def _check(self, path: Path, text: str, named_at: Location | None, naming_text: str) -> None:
        """Refuse what includes itself, or grows beyond the limits: files that include others twice double."""
        self._files += 1
        self._size += len(text)
        message = ""
        if _real(path) in self._open:
            message = "files that include each other"
        elif len(self._open) > MAX_INCLUDE_DEPTH:
            message = f"more than {MAX_INCLUDE_DEPTH} files in a chain of includes"
        elif self._files > MAX_FILES or self._size > MAX_SOURCE:
            message = f"a program of more than {MAX_FILES:,} files, or {MAX_SOURCE:,} characters, with what it includes"
        if message:
            raise BdiSyntaxError.at(message, named_at or Location(str(path), 1, 1), naming_text)


def _is_within(path: Path, project: Path) -> bool:
    """Whether a file is in the folder of a project, or in the current one, or below."""
    return any(_real(path).is_relative_to(_real(folder)) for folder in (project, Path()))


def _real(path: Path) -> Path:
    return Path(os.path.realpath(path))  # resolve() raises RuntimeError for a link to itself


def _without_contents(error: BdiError, path: Path) -> str:
    """The error without anything of the file: a model that comes from elsewhere may name any file of the reader's."""
    place = f"{path}:{error.line}:{error.column}" if isinstance(error, BdiSyntaxError) else f"{path}"
    return f"{place}: not AgentSpeak; details are not shown, because the file is outside of the project's folder"


def parse_term(text: str) -> Term:
    """Parse one term. Raises BdiSyntaxError: the text is not a term."""
    term: Term = _parse(text, "<term>", "one_term")
    return term


@lru_cache(maxsize=4096)  # far more than the percepts of a model: bounded for texts that are made anew in each run
def parse_literal(text: str) -> Structure:
    """Parse a literal such as a percept, ``chosen(leg1)``; results are cached.

    Raises:
        BdiSyntaxError: the text is not a literal.
    """
    literal = parse_term(text)
    if not isinstance(literal, Structure):
        raise BdiSyntaxError.at(f"expected a literal, found {literal}", Location("<literal>", 1, 1), text)
    return literal


def parse_trigger(text: str) -> PlanTrigger:
    """Parse a triggering event such as ``+done(X)``. Raises BdiSyntaxError: the text is not a triggering event."""
    trigger: PlanTrigger = _parse(text, "<event>", "one_trigger")
    return trigger


def parse_plan(text: str) -> Plan:
    """Parse a plan with its final full stop. Raises BdiSyntaxError: the text is not a plan."""
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
        item = transformer.transform(lark.parse(text, start=start))
        if start != "start" and transformer.has_spaces:
            (item,) = namespaces.in_spaces([item], namespaces.DEFAULT, count(1))
        return item
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
