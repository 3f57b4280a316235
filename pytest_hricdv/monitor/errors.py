"""What the monitors raise, and where in a requirement file it went wrong."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches


class RequirementError(ValueError):
    """A requirement file, or the text of a formula in it, is wrong.

    The text says where (file, requirement, line and column), shows the line with a caret under the place, and says
    what was expected, what came and what to do. `position` is the index of the first wrong character in the formula,
    or None when the file and not a formula is wrong.
    """

    def __init__(self, text: str, position: int | None = None) -> None:
        super().__init__(text)
        self.position = position


class MonitorError(RuntimeError):
    """A run was fed to the monitors wrongly: back in time, a value that is NaN, of the wrong type, or missing."""


def no_value_yet(requirement: str, time_s: float, name: str) -> MonitorError:
    """The error of a requirement that reads `name` before it has a value."""
    advice = "signals need a value from the start of the run; guard a field with on(topic) & ..."
    return MonitorError(f"{requirement} at {time_s} s reads {name}, which has no value yet; {advice}")


def never_a_value(requirement: str, names: Iterable[str]) -> MonitorError:
    """The error of a requirement over signals that the run had no value of at all."""
    text = f"{requirement} reads {', '.join(names)}, which had no value in the whole run: feed every signal"
    return MonitorError(text)


class UnknownValueError(LookupError):
    """A formula read a signal or field that has had no value yet. Internal: becomes a `MonitorError` with the time."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.name = name


@dataclass(frozen=True)
class FormulaSource:
    """Where the text of a formula comes from, to point into it.

    Attributes:
        formula: the text of the formula, which may have several lines.
        requirement: the requirement's id; empty for a formula that stands alone.
        path: the file, as the user named it; empty for a formula that stands alone.
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
        # Tabs are kept in front of the caret, so that it stands right whatever a terminal makes of them.
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
        """Where the formula starts in the file; None if it is written with escapes and so cannot be found."""
        name = re.escape(self.requirement)
        header = re.search(rf"^[ \t]*\[[ \t]*[\"']?{name}[\"']?[ \t]*\]", self.document, re.MULTILINE)
        if not self.document or header is None:
            return None
        opening = r"^[ \t]*[\"']?formula[\"']?[ \t]*=[ \t]*(?:\"\"\"\n?|'''\n?|\"|')"
        formula = re.compile(f"{opening}({re.escape(self.formula)})", re.MULTILINE)
        found = formula.search(self.document, header.end())
        return found.start(1) if found else None


def _line_and_column(text: str, index: int) -> tuple[int, int]:
    """Both counted from 1."""
    return text.count("\n", 0, index) + 1, index - text.rfind("\n", 0, index)


def nearest(name: str, known: Iterable[str]) -> str:
    """Advice for an unknown name: the nearest known one if there is one, and all that are known."""
    names = sorted(known)
    close = get_close_matches(name, names, n=1, cutoff=0.6)
    hint = f"did you mean {close[0]!r}? " if close else ""
    return f"{hint}known: {', '.join(names)}" if names else "none is known"
