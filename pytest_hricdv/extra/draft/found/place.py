"""Where something is in the code."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, order=True)
class Place:
    """A line of the code: its file, relative to the folder that the package is in, and the line from 1.

    Line 0 is none: what was observed has only words for where, in the place of the file.
    """

    file: str
    line: int

    def __str__(self) -> str:
        return f"{self.file}:{self.line}" if self.line else self.file
