"""Lines on a run in the text of a failing test (`explanation`): actions of people around an instant, and log lines."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from pytest_hricdv._base.error_text import error_text
from pytest_hricdv._base.message import MAX_TEXT, cut, visible
from pytest_hricdv.report.formatting import plural, seconds

MAX_ACTIONS = 14
"""Most actions shown with `-v`. Chosen: the text of a failure with its traceback is about a screen of a terminal."""

BRIEF_ACTIONS = 10
"""Most actions shown without `-v`. Chosen: with causes and a line for each test, 20 failures fit on two screens."""


def list_actions(actions: Sequence[str], name: str, who: str = "the human") -> Iterator[str]:
    """The first actions of a test, where it is not known when they began.

    Args:
        name: the test's name, for the first line.
        who: did them.
    """
    yield f"what {who} did ({name}):"
    shown = actions if len(actions) <= MAX_ACTIONS else actions[: MAX_ACTIONS - 1]
    for action in shown:
        yield f"  {action}"
    if len(shown) < len(actions):
        yield f"  ... and {plural(len(actions) - len(shown), 'more action')}"
    if not actions:
        yield "  nothing"


def actions_around(
    actions: Sequence[str],
    times: Sequence[float],
    at_s: float,
    name: str,
    event: str = "",
    who: str = "the human",
    most: int = MAX_ACTIONS,
) -> Iterator[str]:
    """The actions before and after an instant, with the times at which they began.

    Args:
        actions: the actions, in the order in which they began.
        times: when they began (s); shorter than `actions` where the run was over before.
        at_s: the instant (s).
        name: the test's name, for the first line.
        event: what happened there; empty at the end of a run, after which there is nothing.
        most: number of actions shown.
        who: did them.
    """
    at_ms_s = round(at_s, 3)  # as the times are: a disturbance may violate a requirement as it begins
    begun = list(zip(times, actions, strict=False))
    before = [entry for entry in begun if entry[0] <= at_ms_s]
    after = [entry for entry in begun if entry[0] > at_ms_s]
    later = after[: max(4, most - len(before))]
    earlier = before[max(0, len(before) - (most - len(later))) :]
    yield f"what {who} did {'around' if event else 'until'} then ({name}):"
    if len(earlier) < len(before):
        yield f"  {plural(len(before) - len(earlier), 'action')} before, and"
    yield from map(_action_line, earlier)
    if not before:
        yield "  nothing" if not (event and later) else "  nothing before"
    if event:
        yield f"  {seconds(at_s):>10}  --> {event}"
    yield from map(_action_line, later)
    if len(later) < len(after):
        yield f"  and {plural(len(after) - len(later), 'more action')} later"
    if len(begun) < len(actions):
        yield f"  and {plural(len(actions) - len(begun), 'more action')} that had not begun when the run ended"


def _action_line(entry: tuple[float, str]) -> str:
    return f"  {seconds(entry[0]):>10}  {entry[1]}"


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
        """Take a message; if its arguments cannot be formatted, it is shown without them."""
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


def logs_around(lines: Sequence[LogLine], at_s: float) -> Iterator[str]:
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
