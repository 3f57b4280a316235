"""The line below the dots while tests run: how far, what is running, how long it will take."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TextIO

from pytest_hricdv.report.line import fit, visible, width

_ERASE_BELOW = "\x1b[J"
_CLEAR_LINE = "\x1b[2K"
_UP = "\x1b[A"
_MINUTE_S, _HOUR_S = 60, 3600


@dataclass(frozen=True)
class Standing:
    """How a session stands.

    Args:
        done: tests that are over.
        total: tests that were chosen.
        failed: of the ones that are over, how many failed.
        left_s: seconds until all are over, guessed; None where nothing is over yet to guess from.
        running: ids of the tests that are running.
    """

    done: int
    total: int
    failed: int
    left_s: float | None
    running: tuple[str, ...]


def line(standing: Standing, columns: int) -> str:
    """`hri: 37 of 134, 2 failed, about 40 s left: rl-leg1-bored-0f3a9c21 and 1 more`, in at most so many columns."""
    parts = [f"{standing.done} of {standing.total}"]
    if standing.failed:
        parts.append(f"{standing.failed} failed")
    if standing.left_s is not None and standing.done < standing.total:
        parts.append(left(standing.left_s))
    start = f"hri: {', '.join(parts)}"
    if not standing.running:
        return fit(start, columns)
    return fit(f"{start}: {_names(standing.running, columns - width(start) - 2)}", columns)


def still(left_s: float, waiting_s: float, passed_s: float) -> float:
    """Seconds that are left when some have passed since `left_s` were guessed: fewer, but what waits takes its time."""
    return max(left_s - passed_s, waiting_s, 0.0)


def left(seconds: float) -> str:
    """`about 40 s left`, `about 3 min left`, `about 2 h 10 min left`: as exact as a guess can be."""
    if seconds < 10:
        return "a few seconds left"
    if seconds < 1.5 * _MINUTE_S:
        return f"about {round(seconds / 5) * 5} s left"
    minutes = round(seconds / _MINUTE_S)
    if seconds < _HOUR_S:
        return f"about {minutes} min left"
    return f"about {minutes // 60} h {minutes % 60} min left"


def _names(ids: Sequence[str], columns: int) -> str:
    shown = [visible(each) for each in ids]
    for count in range(len(shown), 0, -1):
        more = f" and {len(shown) - count} more" if count < len(shown) else ""
        text = ", ".join(shown[:count]) + more
        if width(text) <= columns or count == 1:
            return text
    return ""


class Below:
    """A terminal's file with one more line below the one that is being written; it goes before anything is written.

    Whatever else writes to the terminal (a failing test's text, another plugin, a worker that crashed) therefore finds
    the terminal as if the line was not there.

    Args:
        file: the terminal.
        aside: the same terminal, for the line itself; what was written to `file` has to be flushed before it is shown.
        column: how many columns of the current line are written.
    """

    def __init__(self, file: TextIO, aside: TextIO, column: Callable[[], int]) -> None:
        self._file = file
        self._aside = aside
        self._column = column
        self._shown = ""

    def show(self, text: str) -> None:
        """Put the line there, or another in its place; the cursor stays where it is."""
        if text == self._shown:
            return
        self._shown = text
        self._aside.write(f"\n{_CLEAR_LINE}{text}{_UP}\x1b[{self._column() + 1}G")
        self._aside.flush()

    def clear(self) -> None:
        """Take the line away."""
        if self._shown:
            self._shown = ""
            self._file.write(_ERASE_BELOW)
            self._file.flush()

    def write(self, text: str) -> int:
        """See `io.TextIOBase`."""
        self.clear()
        return self._file.write(text)

    def flush(self) -> None:
        """See `io.TextIOBase`."""
        self._file.flush()

    def __getattr__(self, name: str) -> object:
        return getattr(self._file, name)
