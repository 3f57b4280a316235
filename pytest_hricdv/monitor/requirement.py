"""`Requirement`: a formula with its id, title and source; and `RequirementError`s that point into its text.

`load_requirements` and `build.requirement` make requirements; monitors judge them, and reports show them. A
`FormulaSource` is the text that a parser reads, with its place in a file.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Protocol

from pytest_hricdv._base.message import EXCERPT_WIDTH, InputError, excerpt
from pytest_hricdv.monitor.formula import Formula
from pytest_hricdv.monitor.node import PastFormula


class Criterion(Protocol):
    """A criterion that gives each run one verdict: a requirement, or an agent of the model (`extra.oracle`)."""

    @property
    def id(self) -> str:
        """Its name in reports, such as `R1`."""

    @property
    def title(self) -> str:
        """Its demand in one sentence."""

    @property
    def source(self) -> str:
        """Where it comes from; may be empty."""

    @property
    def text(self) -> str:
        """The text as written, for reports."""

    @property
    def group(self) -> str:
        """The group in which reports list it, such as "safety"; may be empty."""


@dataclass(frozen=True)
class Requirement:
    """One requirement.

    Attributes:
        id: the name of its table in the file, such as `R1`.
        title: the requirement in one sentence.
        source: where it comes from (a clause of a standard, a paper); may be empty.
        text: the formula as written, for reports; below it, the definitions that it uses. Or a pattern as written, and
            below it its formula.
        formula: the formula as data.
        group: what it belongs to, such as "safety"; reports list the requirements of a group together. May be empty.
        shows: numeric signals that a violation reports in addition to those that the formula reads: while a violation
            lasts, the value with the largest absolute value. They have no effect on verdicts.
        suggested: what it rests on, of a requirement that was suggested from runs; empty for others.
        accepted_by: who accepted it; empty if nobody says so.
        accepted_on: when, as `2026-11-26`; empty likewise.
        names: the conditions in the formula that have a definition, each with its name; by it, verdicts show a part.
    """

    id: str
    title: str
    source: str
    text: str
    formula: Formula
    shows: tuple[str, ...] = ()
    group: str = ""
    names: tuple[tuple[PastFormula, str], ...] = ()
    suggested: str = ""
    accepted_by: str = ""
    accepted_on: str = ""


class RequirementError(InputError, ValueError):
    """A requirement file, or the text of a formula in it, is wrong.

    The message gives the place (file, requirement, line and column), shows the line with a caret under the place, and
    says what was expected, what was found and what to do. `position` is the index of the first wrong character in the
    formula, or None if the error is in the file and not in a formula.
    """

    def __init__(self, text: str, position: int | None = None) -> None:
        super().__init__(text)
        self.position = position


@dataclass(frozen=True)
class FormulaSource:
    """Where the text of a formula comes from; makes errors that point into it.

    Attributes:
        formula: the text of the formula; it may have several lines.
        requirement: the requirement's id; empty for a formula without a requirement.
        path: the file, as the user named it; empty for a formula without a file.
        document: the whole text of that file.
        definition: the name of the definition that it is the formula of; empty for another formula.
        owner: what the formula belongs to if not to a requirement or a definition; named in errors.
        key: the key of the requirement that has the text in the file.
        is_built: whether it is the text of a formula that was built in Python.
    """

    formula: str
    requirement: str = ""
    path: str = ""
    document: str = ""
    definition: str = ""
    owner: str = "formula"
    key: str = "formula"
    is_built: bool = False

    def error(self, start: int, end: int, problem: str, advice: str = "") -> RequirementError:
        """The error whose caret line marks `formula[start:end]`."""
        start = min(start, len(self.formula))
        line_start = self.formula.rfind("\n", 0, start) + 1
        line = self.formula[line_start:].split("\n", 1)[0]
        column = start - line_start
        # At least one caret, even behind the end of the text; none beyond the line if a formula continues.
        width = max(1, min(end, line_start + len(line)) - start)
        line, column = excerpt(line, column)
        width = max(1, min(width, EXCERPT_WIDTH - column))
        # Tabs are kept before the caret, so that it is in the right column for any tab width of the terminal.
        indent = "".join("\t" if character == "\t" else " " for character in line[:column])
        text = f"{self._place(start)}: {problem}\n    {line}\n    {indent}{'^' * width}"
        return RequirementError(f"{text}\n{advice}" if advice else text, start)

    def _place(self, start: int) -> str:
        owner = f"requirement {self.requirement}" if self.requirement else self.owner
        owner = f"definition {self.definition}" if self.definition else owner
        line, column = _line_and_column(self.formula, start)
        within = f"column {column}" if "\n" not in self.formula else f"line {line}, column {column}"
        offset = self._offset_in_document()
        if offset is not None:
            file_line, file_column = _line_and_column(self.document, offset + start)
            return f"{self.path}:{file_line}:{file_column}: {owner}, {within} of the {self.key}"
        return f"{self.path}: {owner}, {within}" if self.path else f"{owner}, {within}"

    def _offset_in_document(self) -> int | None:
        """Where the formula starts in the file; None if it is written with escapes and cannot be found."""
        name = re.escape("definitions" if self.definition else self.requirement)
        key = re.escape(self.definition or self.key)
        header = re.search(rf"^[ \t]*\[[ \t]*[\"']?{name}[\"']?[ \t]*\]", self.document, re.MULTILINE)
        if not self.document or header is None:
            return None
        opening = rf"^[ \t]*[\"']?{key}[\"']?[ \t]*=[ \t]*(?:\"\"\"\n?|'''\n?|\"|'|)"
        formula = re.compile(f"{opening}({re.escape(self.formula)})", re.MULTILINE)
        match = formula.search(self.document, header.end())
        return match.start(1) if match else None


def _line_and_column(text: str, index: int) -> tuple[int, int]:
    """Both counted from 1."""
    return text.count("\n", 0, index) + 1, index - text.rfind("\n", 0, index)
