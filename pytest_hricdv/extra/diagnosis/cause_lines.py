"""A cause in the terminal: at most eight lines, which fit, except that a command is never cut."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.diagnosis.records import Cause
from pytest_hricdv.report.explanation import replay_command
from pytest_hricdv.report.formatting import Line, Style, and_more, fit, fit_path, plural, width, wrap

MOST_LINES = 8
"""Of a cause in the terminal."""

_MOST_ACTIONS = 3
MOST_PLACES = 2
_MOST_REQUIREMENTS = 8
_MOST_WRAPPED = 2
"""Lines of a sentence; chosen: then all of a cause is in `MOST_LINES`."""


def cause_lines(
    number: int,
    cause: Cause,
    options: Sequence[str],
    columns: int | None,
    status: str = "",
    most_places: int = MOST_PLACES,
) -> tuple[Line, ...]:
    """What it is, where, what decides, its shortest test, and the command that runs this again.

    Args:
        number: of the cause, from 1.
        options: of the session, as far as a replay needs them.
        columns: of the terminal; None where lines may have any width.
        most_places: so many statements are named.
        status: as `new`, compared with a baseline; empty where there is nothing to say.
    """
    places = cause.places[:most_places]
    lines = [
        *_sentence(title_of(number, cause, status), columns, "  "),
        *(_place(place.file, place.line, place.function, place.score, place.text, columns) for place in places),
    ]
    style: Style = "warn" if cause.is_known else "bad"
    shown = [Line(text, style if number == 0 else "plain") for number, text in enumerate(lines)]
    if cause.decides:
        shown += [Line(text) for text in _sentence(f"  {cause.decides}", columns, "    ")]
    shown += [Line(_shortest(cause, columns))]
    if command := replay_of(cause, options):
        shown.append(Line(f"  {visible(command)}", "dim"))
    while len(shown) > MOST_LINES:  # the second place, or the end of a sentence: all is on the page
        del shown[2]
    return tuple(shown)


def title_of(number: int, cause: Cause, status: str = "") -> str:
    """`cause 1 (3f2a91bc, new): R29, R21 in 6 tests, first in the state releasing`."""
    return f"cause {number} ({cause.id}{f', {status}' if status else ''}): {summary_of(cause)}"


def summary_of(cause: Cause) -> str:
    """`R29, R21 in 6 tests, first in the state releasing`."""
    names, left = cause.requirements[:_MOST_REQUIREMENTS], len(cause.requirements) - _MOST_REQUIREMENTS
    listed = ", ".join(names) + and_more(max(left, 0))
    where = f", first in the state {cause.state}" if cause.state else ""
    many = plural(len(cause.tests), "test")
    if (share := cause.probability) is not None:
        percent = 100 * share.failing / share.runs
        many = f"{share.failing:,} of {share.runs:,} runs, {percent:.2f} % ({share.low:.2f} to {share.high:.2f})"
    return f"{listed} in {many}{where}{' (known)' if cause.is_known else ''}"


def replay_of(cause: Cause, options: Sequence[str]) -> str:
    """The command that runs its shortest test again; empty where this has no file."""
    return replay_command(cause.replay, options) if cause.replay else ""


def _place(file: str, line: int, function: str, score: float, text: str, columns: int | None) -> str:
    """`  at file:line in function, 0.87: the line`; of what is too long, the statement is cut before the place."""
    place = visible(f"{file}:{line}")
    rest = visible(f" in {function}, {score:.2f}: {text}")
    if columns is None:
        return f"  at {place}{rest}"
    return fit(f"  at {fit_path(place, max(columns - 5, 8))}{rest}", columns)


def _shortest(cause: Cause, columns: int | None) -> str:
    """The test, whose id is not cut, and its first actions, as far as there is room."""
    kind = "what is left of" if cause.is_shrunk else "shortest test"
    start = visible(f"  {kind} {cause.minimal_of or cause.tests[0]}")
    for count in range(min(_MOST_ACTIONS, len(cause.minimal)), 0, -1):
        left = len(cause.minimal) - count
        text = f"{start}: {visible('; '.join(cause.minimal[:count]))}{f'; ... {left} more' if left else ''}"
        if columns is None or width(text) <= columns:
            return text
    return start


def _sentence(text: str, columns: int | None, indent: str) -> Iterator[str]:
    """A sentence in at most `_MOST_WRAPPED` lines, the later ones indented."""
    shown = visible(text)
    if columns is None or width(shown) <= columns:
        yield shown
        return
    begin = shown[: len(shown) - len(shown.lstrip())]
    lines = wrap(shown.split(), columns - len(indent))
    kept = lines[:_MOST_WRAPPED]
    if len(lines) > len(kept):
        kept[-1] = fit(f"{kept[-1]} {lines[len(kept)]}", columns - len(indent))
    yield from (f"{indent if number else begin}{line}" for number, line in enumerate(kept))
