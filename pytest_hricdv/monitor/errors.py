"""The errors of this package, and the location of an error in a requirement file."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass


class RequirementError(ValueError):
    """A requirement file, or the text of a formula in it, is wrong.

    The text gives the place (file, requirement, line and column), shows the line with a caret under the place, and
    says what was expected, what was found and what to do. `position` is the index of the first wrong character in the
    formula, or None if the error is in the file and not in a formula.
    """

    def __init__(self, text: str, position: int | None = None) -> None:
        super().__init__(text)
        self.position = position


class MonitorError(RuntimeError):
    """The monitors were fed wrongly: time went back, or a value is NaN, of the wrong type, or missing."""


def unset_value_error(requirement: str, time_s: float, name: str) -> MonitorError:
    """The error of a requirement that reads `name` before it has a value."""
    advice = "signals need a value from the start of the run; guard a field with on(topic) & ..."
    return MonitorError(f"{requirement} at {time_s} s reads {name}, which has no value yet; {advice}")


def unset_signals_error(requirement: str, names: Iterable[str]) -> MonitorError:
    """The error of a requirement that reads signals which had no value in the whole run."""
    text = f"{requirement} reads {', '.join(names)}, which had no value in the whole run: feed every signal"
    return MonitorError(text)


@dataclass(frozen=True)
class FormulaSource:
    """Where the text of a formula comes from; makes errors that point into it.

    Attributes:
        formula: the text of the formula; it may have several lines.
        requirement: the requirement's id; empty for a formula without a requirement.
        path: the file, as the user named it; empty for a formula without a file.
        document: the whole text of that file.
    """

    formula: str
    requirement: str = ""
    path: str = ""
    document: str = ""

    def error(self, start: int, end: int, problem: str, advice: str = "") -> RequirementError:
        """The error whose caret line marks `formula[start:end]`."""
        start = min(start, len(self.formula))
        line_start = self.formula.rfind("\n", 0, start) + 1
        line = self.formula[line_start:].split("\n", 1)[0]
        column = start - line_start
        width = max(1, min(end, line_start + len(line)) - start)
        # Tabs are kept before the caret, so that it is in the right column for any tab width of the terminal.
        indent = "".join("\t" if character == "\t" else " " for character in line[:column])
        text = f"{self._place(start)}: {problem}\n    {line}\n    {indent}{'^' * width}"
        return RequirementError(f"{text}\n{advice}" if advice else text, start)

    def _place(self, start: int) -> str:
        owner = f"requirement {self.requirement}" if self.requirement else "formula"
        line, column = _line_and_column(self.formula, start)
        within = f"column {column}" if "\n" not in self.formula else f"line {line}, column {column}"
        offset = self._offset_in_document()
        if offset is not None:
            file_line, file_column = _line_and_column(self.document, offset + start)
            return f"{self.path}:{file_line}:{file_column}: {owner}, {within} of the formula"
        return f"{self.path}: {owner}, {within}" if self.path else f"{owner}, {within}"

    def _offset_in_document(self) -> int | None:
        """Where the formula starts in the file; None if it is written with escapes and cannot be found."""
        name = re.escape(self.requirement)
        header = re.search(rf"^[ \t]*\[[ \t]*[\"']?{name}[\"']?[ \t]*\]", self.document, re.MULTILINE)
        if not self.document or header is None:
            return None
        opening = r"^[ \t]*[\"']?formula[\"']?[ \t]*=[ \t]*(?:\"\"\"\n?|'''\n?|\"|')"
        formula = re.compile(f"{opening}({re.escape(self.formula)})", re.MULTILINE)
        match = formula.search(self.document, header.end())
        return match.start(1) if match else None


def _line_and_column(text: str, index: int) -> tuple[int, int]:
    """Both counted from 1."""
    return text.count("\n", 0, index) + 1, index - text.rfind("\n", 0, index)
