"""The status line: its text, and how it is drawn below the cursor of a terminal."""

from __future__ import annotations

import os
import sys
from dataclasses import dataclass

from pytest_hricdv.report.formatting import fit, visible, width

_MINUTE_S, _HOUR_S = 60, 3600

# Index and reverse index make room for a line below: they scroll at the bottom of the screen. Then: save the cursor,
# next line, erase it, text, restore the cursor.
_DRAW = "\x1bD\x1bM\x1b7\x1bE\x1b[2K{}\x1b8"
_ERASE_BELOW = "\x1b[J"


@dataclass(frozen=True)
class Status:
    """How far a session is.

    Args:
        done: tests that have ended.
        total: selected tests.
        failed: of those that have ended, how many failed.
        left_s: estimated seconds to the end of the last test; None as long as too few have ended.
        running: ids of the tests that are running.
    """

    done: int
    total: int
    failed: int
    left_s: float | None
    running: tuple[str, ...]

    def text(self, columns: int) -> str:
        """`hri: 37 of 134, 2 failed, about 40 s left: rl-leg1-0f3a9c21 and 1 more`, in at most so many columns."""
        parts = [f"hri: {self.done} of {self.total}"]
        if self.failed:
            parts.append(f"{self.failed} failed")
        if self.left_s is not None and self.done < self.total:
            parts.append(time_left(self.left_s))
        start, shown = ", ".join(parts), [visible(each) for each in self.running]
        for count in range(len(shown), 0, -1):
            more = f" and {len(shown) - count} more" if count < len(shown) else ""
            text = f"{start}: {', '.join(shown[:count])}{more}"
            if count == 1 or width(text) <= columns:
                return fit(text, columns)
        return fit(start, columns)


def time_left(seconds: float) -> str:
    """`about 40 s left`, `about 3 min left`, `about 2 h 10 min left`: rounded, as it is an estimate."""
    if seconds < 10:
        return "a few seconds left"
    if seconds < 1.5 * _MINUTE_S:
        return f"about {round(seconds / 5) * 5} s left"
    minutes = round(seconds / _MINUTE_S)
    if seconds < _HOUR_S:
        return f"about {minutes} min left"
    return f"about {minutes // 60} h {minutes % 60} min left"


class StatusLine:
    """One line below the cursor, where pytest writes next. It has to be erased before anything else is written.

    Args:
        descriptor: of the terminal; `close` closes it.
        encoding: of the terminal.
    """

    def __init__(self, descriptor: int, encoding: str) -> None:
        self._descriptor = descriptor
        self._encoding = encoding

    @classmethod
    def open(cls) -> StatusLine | None:
        """On standard output; None where that is no terminal, or one without control sequences.

        Call it while pytest does not capture output. The descriptor is a duplicate, so that the line can be drawn while
        the output of a test is captured.
        """
        if os.name != "posix" or os.environ.get("TERM", "dumb") == "dumb" or not sys.stdout.isatty():
            return None
        return cls(os.dup(sys.stdout.fileno()), sys.stdout.encoding)

    def draw(self, text: str) -> None:
        """Show a text in place of the one before; the cursor stays where it is."""
        self._write(_DRAW.format(text))

    def erase(self) -> None:
        """Remove the line."""
        self._write(_ERASE_BELOW)

    def close(self) -> None:
        """Release the terminal."""
        os.close(self._descriptor)

    def _write(self, text: str) -> None:
        os.write(self._descriptor, text.encode(self._encoding, errors="replace"))
