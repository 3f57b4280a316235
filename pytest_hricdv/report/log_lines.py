"""Log records of a run with simulated times, for the text of a failing test."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from pytest_hricdv._base.error_text import error_text
from pytest_hricdv._base.message import MAX_TEXT, cut, visible
from pytest_hricdv.report.formatting import seconds

MAX_BEFORE, MAX_AFTER = 8, 3
"""Shown around an instant (chosen): with the actions about a screen of a terminal. pytest shows all it captured."""


@dataclass(frozen=True)
class LogLine:
    """A message that a logger took.

    Args:
        time_s: simulated (s).
        text: level, logger and message, in a line.
    """

    time_s: float
    text: str


class RunLog(logging.Handler):
    """Takes what the root logger gets during a run; levels stay as the project has set them.

    A context manager. `now_s` tells the simulated time, once the run has begun.
    """

    def __init__(self) -> None:
        super().__init__()
        self.now_s: Callable[[], float] = lambda: 0.0
        self._lines: deque[LogLine] = deque(maxlen=1_000)

    def __enter__(self) -> RunLog:
        logging.getLogger().addHandler(self)
        return self

    def __exit__(self, *raised: object) -> None:
        logging.getLogger().removeHandler(self)

    def emit(self, record: logging.LogRecord) -> None:
        """Take a message; one that cannot be written is as its author has it, before its arguments."""
        try:
            message = record.getMessage()
        except Exception:  # pytest and logging itself say so
            message = str(record.msg)
        first, _, more = cut(message, MAX_TEXT).partition("\n")
        error = record.exc_info[1] if record.exc_info else None
        cause = f" ({error_text(error)})" if error is not None else " ..." if more else ""
        text = f"{record.levelname:7} {record.name}: {first}{cause}"
        self._lines.append(LogLine(self.now_s(), visible(text[:160])))

    @property
    def lines(self) -> tuple[LogLine, ...]:
        """The lines in order."""
        return tuple(self._lines)


def around(lines: Sequence[LogLine], at_s: float) -> Iterator[str]:
    """The last messages up to an instant (s), and the first ones after it; nothing where nothing was logged."""
    before = [line for line in lines if line.time_s <= at_s]
    after = [line for line in lines if line.time_s > at_s]
    if not lines:
        return
    yield "what was logged around then:"
    if len(before) > MAX_BEFORE:
        yield f"  {len(before) - MAX_BEFORE} before, and"
    for line in (*before[-MAX_BEFORE:], *after[:MAX_AFTER]):
        yield f"  {seconds(line.time_s):>10}  {line.text}"
    if len(after) > MAX_AFTER:
        yield f"  and {len(after) - MAX_AFTER} later"
