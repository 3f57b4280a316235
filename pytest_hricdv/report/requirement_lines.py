"""The lines on requirements in the terminal's summary."""

from collections.abc import Iterator, Sequence

from pytest_hricdv._base.message import visible
from pytest_hricdv.report import totals
from pytest_hricdv.report.formatting import (
    LABEL_COLUMNS,
    Line,
    Style,
    fit,
    label_lines,
    listing,
    pad,
    plural,
    width,
    wrap,
)
from pytest_hricdv.results.model import Report, SuiteResult

_WIDE = 100
"""Columns from which there is room for triggers beside titles."""


def requirement_lines(report: Report, suite: SuiteResult, columns: int) -> Iterator[Line]:
    """A suite's requirements: how many tests passed and failed each, what was not checked, and what is known."""
    rows = totals.requirement_rows(report, suite)
    if not rows:
        yield Line("  no requirements", "dim")
        return
    yield from requirement_table(rows, columns)
    yield from _nc_lines(rows, columns)
    yield from _describe_pending(rows, columns)
    yield from _describe_xfails(rows, columns)
    yield from _describe_masked_messages(rows, columns)
    if totals.is_whole(report, suite):
        yield from _vacuous_lines(rows, columns)


def requirement_table(rows: Sequence[totals.RequirementRow], columns: int) -> Iterator[Line]:
    """A line of figures for each requirement, with its title where there is room; those that passed without colour."""
    margins = any(row.margin is not None for row in rows)
    known = 7 if any(row.is_tolerated for row in rows) else 0
    triggers = 10 if columns >= _WIDE else 0
    units = max((width(row.unit) + 1 for row in rows if row.unit and row.margin is not None), default=0)
    numbers = 7 + 7 + known + 6 + triggers + (10 + units if margins else 0)
    room = max(columns - numbers - 2, 4)
    head = f"{'Passed':>7}{'Failed':>7}{'known'[:known]:>{known}}{'NC':>6}{'triggers'[:triggers]:>{triggers}}"
    head += "margin".rjust(10) if margins else ""
    yield Line(f"  {pad('requirement' if room > width('requirement') else '', room)}{head}".rstrip(), "dim")
    for group, members in totals.by_group(rows):
        if group:
            yield Line(f"  {visible(group)}", "dim")
        for row in members:
            failed, tolerated = (0, row.failed) if row.is_tolerated else (row.failed, 0)
            margin = "" if row.margin is None else f"{row.margin:.3g}"
            figures = f"{row.passed:>7}{failed:>7}{tolerated or '':>{known}}{row.nc:>6}"
            figures += f"{str(row.triggers)[:triggers]:>{triggers}}{margin:>10}"
            unit = visible(f" {row.unit}" if margin else "")
            is_titled = room - width(visible(row.name)) > 16  # with less room, a title says nothing
            name = pad(visible(f"{row.name} {row.title}" if is_titled else row.name), room)
            if width(visible(row.name)) > room:  # it is what tells rows apart
                yield Line(f"  {visible(row.name)}", _verdict_style(row))
                name = " " * room
            yield Line(f"  {name}{figures}{unit}".rstrip(), _verdict_style(row))


def _nc_lines(rows: Sequence[totals.RequirementRow], columns: int) -> Iterator[Line]:
    unchecked = [row for row in rows if row.nc and not row.passed + row.failed]
    for undecided, why in (
        (False, "no test triggered it"),
        (True, "triggered, but never decided before the run ended"),
    ):
        names = [row.name for row in unchecked if bool(row.triggers) == undecided and not row.allowed_untriggered]
        if names:
            yield from label_lines("NC: not checked", f"{listing(names, columns // 3)}: {why}", columns, "warn")
    for row in unchecked:
        if row.allowed_untriggered:
            yield from label_lines("NC: allowed", f"{row.name}: {row.allowed_untriggered}", columns, "dim")


def _describe_pending(rows: Sequence[totals.RequirementRow], columns: int) -> Iterator[Line]:
    open_ = [f"{row.name}: {plural(row.pending, 'trigger')}" for row in rows if row.pending]
    if open_:
        shown = listing(open_, columns - LABEL_COLUMNS - 30)
        yield from label_lines("pending at the end", f"{shown}, undecided when a run ended", columns, "warn")


def _describe_xfails(rows: Sequence[totals.RequirementRow], columns: int) -> Iterator[Line]:
    for row in rows:
        if row.failed and row.known_reason:
            note = visible(f"{row.name} is known to fail: {row.xfail_note}")
            for line in wrap(note.split(" "), columns - 2):
                yield Line(f"  {line}", "warn" if row.is_tolerated else "bad")


def _vacuous_lines(rows: Sequence[totals.RequirementRow], columns: int) -> Iterator[Line]:
    """Alternatives of responses without which all verdicts would be the same."""
    unused = [f"in {row.name}, never affected the verdict: {text}" for row in rows for text in row.vacuous_alternatives]
    shown = [fit(text, columns - LABEL_COLUMNS - 4) for text in unused]  # the report has the formulas in full
    yield from _first_lines("vacuous", shown, columns)


def _describe_masked_messages(rows: Sequence[totals.RequirementRow], columns: int) -> Iterator[Line]:
    """Messages that requirements read and did not evaluate."""
    texts = [
        f"{row.name} ignored {count} '{topic}' message{'s' * (count != 1)}: only the last message of a topic per "
        f"instant is evaluated. Use last({topic}.FIELD), or publish at distinct times."
        for row in rows
        for topic, count in row.masked_messages.items()
    ]
    yield from _first_lines("warning", texts, columns)


def _first_lines(label: str, texts: Sequence[str], columns: int) -> Iterator[Line]:
    """The first three of the texts, and how many more the report has."""
    rest = [f"{len(texts) - 3} more: see the report"] if len(texts) > 3 else []
    for text in [*texts[:3], *rest]:
        yield from label_lines(label, text, columns, "warn")


def _verdict_style(row: totals.RequirementRow) -> Style:
    if row.failed:
        return "warn" if row.is_tolerated else "bad"
    return "plain" if row.passed else "dim"
