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


def requirement_lines(report: Report, suite: SuiteResult, columns: int, *, brief: bool = False) -> Iterator[Line]:
    """A suite's requirements: how many tests passed and failed each, what was not checked, and what is known.

    Args:
        brief: without those that no test failed, if they are many, and without what never decided.
    """
    rows = totals.requirement_rows(report, suite)
    if not rows:
        yield Line("  no requirements", "dim")
        return
    good = [row for row in rows if not row.failed and (row.passed or row.allowed_untriggered)]
    if brief and len(good) > 8:
        yield from _table([row for row in rows if row not in good], columns)
        yield Line(f"  {len(good)} others: no test failed them; -v lists all", "ok")
    else:
        yield from _table(rows, columns)
    yield from _nc_lines([row for row in rows if not (brief and row.allowed_untriggered)], columns)
    yield from _describe_pending(rows, columns)
    yield from _describe_xfails(rows, columns)
    yield from _describe_masked_messages(rows, columns)
    if totals.is_whole(report, suite) and not brief:
        yield from _vacuous_lines(rows, columns)


def _table(rows: Sequence[totals.RequirementRow], columns: int) -> Iterator[Line]:
    margins = any(row.margin is not None for row in rows)
    marks = 6 if any(row.is_tolerated for row in rows) else 0
    units = max((width(row.unit) + 1 for row in rows if row.unit and row.margin is not None), default=0)
    numbers = 7 + 8 + marks + 6 + 10 + (10 + units if margins else 0)
    room = max(columns - numbers - 2, 4)
    head = f"{'Passed':>7}{'Failed':>8}{'':{marks}}{'NC':>6}{'triggers':>10}{'margin' if margins else '':>10}"
    yield Line(f"  {pad('requirement' if room > width('requirement') else '', room)}{head}".rstrip(), "dim")
    for group, members in totals.by_group(rows):
        if group:
            yield Line(f"  {visible(group)}", "dim")
        for row in members:
            mark = " known" if row.is_tolerated else ""
            margin = "" if row.margin is None else f"{row.margin:.3g}"
            figures = f"{row.passed:>7}{row.failed:>8}{mark:{marks}}{row.nc:>6}{row.triggers:>10}{margin:>10}"
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
    return "ok" if row.passed else "dim"
