"""The actions of people around an instant of a run, as lines in the text of a failing test."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pytest_hricdv.report.formatting import plural, seconds

MAX_ACTIONS = 14
"""Chosen, so that the text of a failure with its traceback is about a screen of a terminal; the report has all."""

BRIEF_ACTIONS = 10
"""Actions shown without `-v`, chosen: with causes and a line for each test, 20 failures fit on two screens."""


def list_actions(actions: Sequence[str], name: str, who: str = "the human") -> Iterator[str]:
    """The first actions of a test, where it is not known when they began.

    Args:
        name: of the test, for the first line.
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


def around(
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
        actions: in the order in which they began.
        times: when they began (s); shorter than `actions` where the run was over before.
        at_s: the instant (s).
        name: of the test, for the first line.
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
    yield from map(_line, earlier)
    if not before:
        yield "  nothing" if not (event and later) else "  nothing before"
    if event:
        yield f"  {seconds(at_s):>10}  --> {event}"
    yield from map(_line, later)
    if len(later) < len(after):
        yield f"  and {plural(len(after) - len(later), 'more action')} later"
    if len(begun) < len(actions):
        yield f"  and {plural(len(actions) - len(begun), 'more action')} that had not begun when the run ended"


def _line(entry: tuple[float, str]) -> str:
    return f"  {seconds(entry[0]):>10}  {entry[1]}"
