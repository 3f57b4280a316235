"""What a terminal shows of what is written to it: as much of one as the plugin and pytest use."""

from __future__ import annotations

import re

_TOKEN = re.compile(
    r"\x1b\[(?P<number>[\d;]*)(?P<command>[A-Za-z])|\x1b(?P<cursor>[DEM78])|\x1b\][^\x07\x1b]*(?:\x07|\x1b\\)"
    r"|(?P<text>[\s\S])"
)


class Screen:
    """Rows of text and a cursor; the screen is `rows` high and scrolls.

    Raises ValueError at a control sequence that it does not know.
    """

    def __init__(self, rows: int = 24, columns: int = 80) -> None:
        self._rows, self._columns = rows, columns
        self._lines = [""]
        self._row = self._column = 0
        self._saved = (0, 0)

    @property
    def lines(self) -> list[str]:
        """All lines, also those that have scrolled away, without blanks at their ends."""
        return [line.rstrip() for line in self._lines]

    def feed(self, text: str) -> None:
        """Show more text."""
        for token in _TOKEN.finditer(text):
            if token["text"] is not None:
                self._put(token["text"])
            elif token["cursor"] is not None:
                self._move(token["cursor"])
            elif token["command"] is not None:
                self._control(token["command"], int(token["number"].partition(";")[0] or 0))

    def _put(self, char: str) -> None:
        if char == "\r":
            self._column = 0
        elif char == "\n":
            self._column = 0  # terminals have a carriage return put in by the system
            self._down()
        elif char.isprintable():
            if self._column == self._columns:
                self._column = 0
                self._down()
            line = self._lines[self._row].ljust(self._column)
            self._lines[self._row] = line[: self._column] + char + line[self._column + 1 :]
            self._column += 1
        else:
            raise ValueError(f"control character {char!r}")

    def _down(self) -> None:
        self._row += 1
        if self._row == len(self._lines):
            self._lines.append("")

    def _move(self, command: str) -> None:
        if command in "DE":  # index, next line
            self._column = 0 if command == "E" else self._column
            self._down()
        elif command == "M":  # reverse index
            self._row = max(self._row - 1, len(self._lines) - self._rows, 0)
        elif command == "7":
            self._saved = (self._row, self._column)
        else:
            self._row, self._column = self._saved

    def _control(self, command: str, number: int) -> None:
        line = self._lines[self._row]
        if command == "K":
            self._lines[self._row] = "" if number == 2 else line[: self._column]
        elif command == "J" and number == 0:
            self._lines[self._row :] = [line[: self._column]]
        elif command != "m":
            raise ValueError(f"control sequence {number}{command}")
