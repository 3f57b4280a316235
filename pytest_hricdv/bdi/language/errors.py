"""Errors in a BDI model and its project file: `BdiError` and its subclasses, and `Location`, a place in a source.

The parser raises `BdiSyntaxError`. After an `EvaluationError` an agent's goal fails; other errors end the run.
"""

from __future__ import annotations

from dataclasses import dataclass

from pytest_hricdv._base.message import InputError, excerpt, legible


@dataclass(frozen=True, slots=True)
class Location:
    """A place in a source file; line and column count from 1."""

    file: str
    line: int
    column: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}:{self.column}"


NO_LOCATION = Location("<text>", 1, 1)
"""The location of text that is not from a file."""


class BdiError(InputError):
    """A model cannot be loaded, or its run cannot continue."""


class BdiSyntaxError(BdiError):
    """AgentSpeak or project text that cannot be parsed.

    Args:
        message: what was expected and what was found.
        file: name of the source file as the user gave it.
        line, column: where the offending text begins, both from 1.
        source_line: the text of that line, shown with a caret under the column.
    """

    def __init__(self, message: str, file: str, line: int, column: int, source_line: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.file = file
        self.line = line
        self.column = column
        self.source_line = source_line

    @classmethod
    def at(cls, message: str, place: Location, text: str) -> BdiSyntaxError:
        """The error at a place of the source ``text``, which supplies the line to show."""
        lines = text.split("\n", place.line)
        source_line = lines[place.line - 1].rstrip("\r") if 0 < place.line <= len(lines) else ""
        return cls(message, place.file, place.line, place.column, source_line)

    def __str__(self) -> str:
        head = f"{self.file}:{self.line}:{self.column}: {self.message}"
        if not self.source_line.strip():
            return legible(head)
        shown, column = excerpt(self.source_line, self.column - 1)
        # Tabs are kept in the indent of the caret so that it stays under its column in any terminal.
        indent = "".join("\t" if c == "\t" else " " for c in shown[:column])
        return legible(f"{head}\n    {shown}\n    {indent}^")


class EvaluationError(BdiError):
    """An expression or internal action has no value: its goal fails, and the agent continues.

    Args:
        message: what is wrong.
        kind: Jason's name for the kind of failure, the value of the annotation ``error`` of the failure event.
    """

    def __init__(self, message: str, kind: str = "ia_failed") -> None:
        super().__init__(message)
        self.kind = kind
