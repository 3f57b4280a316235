"""The brief summary of a session, at most a screen: for each part a line with counts, then its first details.

`terminal` prints these `brief_lines` without `-v`; its full summary has the same `requirement_lines`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from pytest_hricdv._base.message import visible
from pytest_hricdv.report import behaviour_view, totals
from pytest_hricdv.report.formatting import (
    LABEL_COLUMNS,
    Line,
    Style,
    fit,
    fit_path,
    label_lines,
    listing,
    pad,
    plural,
    width,
    wrap,
)
from pytest_hricdv.report.view import views
from pytest_hricdv.results.model import Report, SuiteResult

_WIDE = 100
"""Columns from which there is room for triggers next to titles."""


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
    """A line of figures for each requirement, with its title where there is room; passed ones without colour."""
    margins = any(row.margin is not None for row in rows)
    known_width = 7 if any(row.is_tolerated for row in rows) else 0
    triggers = 10 if columns >= _WIDE else 0
    units = max((width(row.unit) + 1 for row in rows if row.unit and row.margin is not None), default=0)
    numbers = 7 + 7 + known_width + 6 + triggers + (10 + units if margins else 0)
    room = max(columns - numbers - 2, 4)
    head = (
        f"{'Passed':>7}{'Failed':>7}{'known'[:known_width]:>{known_width}}{'NC':>6}{'triggers'[:triggers]:>{triggers}}"
    )
    head += "margin".rjust(10) if margins else ""
    yield Line(f"  {pad('requirement' if room > width('requirement') else '', room)}{head}".rstrip(), "dim")
    for group, members in totals.by_group(rows):
        if group:
            yield Line(f"  {visible(group)}", "dim")
        for row in members:
            failed, tolerated = (0, row.failed) if row.is_tolerated else (row.failed, 0)
            margin = "" if row.margin is None else f"{row.margin:.3g}"
            figures = f"{row.passed:>7}{failed:>7}{tolerated or '':>{known_width}}{row.nc:>6}"
            figures += f"{str(row.triggers)[:triggers]:>{triggers}}{margin:>10}"
            unit = visible(f" {row.unit}" if margin else "")
            is_titled = room - width(visible(row.name)) > 16  # with less room, a title says nothing
            name = pad(visible(f"{row.name} {row.title}" if is_titled else row.name), room)
            if width(visible(row.name)) > room:  # it distinguishes the rows
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


GREEN_LINES, RED_LINES = 6, 14
"""Number of lines of all parts of a session together, if there are not more parts. With pytest's own lines, a session
that passes has at most 15, and one that fails for one cause 35."""

_LABEL = 14

Part = list[Line]
"""Its first line, which is always shown, and its details, the most important first."""


def brief_lines(report: Report, columns: int, notes: int = 0, *, is_red: bool = False) -> Iterator[Line]:
    """A few lines of limited width on requirements, gaps, changes, and results of features.

    Args:
        notes: number of other lines shown.
        is_red: whether the session fails.
    """
    parts = [_requirements(report, columns), _describe_gaps(report, columns), [*behaviour_view.lines(report, columns)]]
    parts += [_feature_part([*view.lines(report, columns)]) for view in views()]
    parts = [part for part in parts if part]
    for part in _share_lines(parts, (RED_LINES if is_red else GREEN_LINES) - notes):
        yield from (Line(fit(visible(line.text), columns), line.style) for line in part)


def _share_lines(parts: Sequence[Part], most: int) -> Iterator[Part]:
    """The first lines of parts, one more of each in turn while all together are no more than `most`."""
    shown = [1] * len(parts)
    while True:
        for number, part in enumerate(parts):
            if sum(shown) >= most or shown == [len(part) for part in parts]:
                yield from (part[:count] for part, count in zip(parts, shown, strict=True))
                return
            shown[number] += shown[number] < len(part)


def _feature_part(lines: Part) -> Part:
    """The first line of a feature, and what it warns of."""
    return [*lines[:1], *(line for line in lines[1:] if line.style in ("bad", "warn"))]


def _requirements(report: Report, columns: int) -> Part:
    rows = totals.join_rows(report)
    if not rows:
        return [Line(f"{'requirements':{_LABEL}}none", "warn")]
    failed = [row for row in rows if row.failed and not row.is_tolerated]
    tolerated = [row for row in rows if row.is_tolerated]
    unchecked = [row for row in rows if not row.passed + row.failed]
    passed = len(rows) - len(failed) - len(tolerated) - len(unchecked)
    head = f"{'requirements':{_LABEL}}{passed} of {len(rows)} passed"
    head += f", {len(unchecked)} never checked" if unchecked else ""
    lines = [*requirement_table(failed, columns)] if failed else []
    lines += [
        Line(f"  {row.name} known to fail in {plural(row.failed, 'test')}: {row.xfail_note}", "warn")
        for row in tolerated
    ]
    lines += [
        Line(f"  {row.name} undecided when a run ended, after {plural(row.pending, 'trigger')}", "warn")
        for row in rows
        if row.pending
    ]
    lines += [
        Line(
            f"  {row.name} ignored {count} '{topic}' message{'s' * (count != 1)}: only the last of an instant counts",
            "warn",
        )
        for row in rows
        for topic, count in row.masked_messages.items()
    ]
    for row in sorted(unchecked, key=lambda row: bool(row.allowed_untriggered)):
        why = "triggered, but never decided" if row.triggers else "no test triggered it"
        text = f"allowed: {row.allowed_untriggered}" if row.allowed_untriggered else why
        lines.append(Line(f"  {row.name} never checked, {text}", "dim" if row.allowed_untriggered else "warn"))
    return [Line(head + _least_margins(rows, columns - width(head)), "bad" if failed else "plain"), *lines]


def _least_margins(rows: Sequence[totals.RequirementRow], columns: int) -> str:
    """`; least margins R4 0.01 rad/s, R9 0.983 s`: of each unit the least, as far as there is room."""
    least: dict[str, str] = {}
    passed = [row for row in rows if row.margin is not None and row.passed and not row.failed and row.unit]
    for row in sorted(passed, key=lambda row: row.margin or 0.0):
        least.setdefault(row.unit, f"{row.name} {row.margin:.3g} {row.unit}")
    margins = [*least.values()]
    texts = (f"; least margins {', '.join(margins[:count])}" for count in range(len(margins), 0, -1))
    return next((text for text in texts if width(text) <= columns), "")


def _describe_gaps(report: Report, columns: int) -> Part:
    """How much is not covered, code first, and where."""
    code, gaps = report.code_under_test, totals.gaps(report)
    counts = {kind: sum(gap.count for gap in gaps if gap.kind == kind) for kind in totals.GAP_NOUNS}
    listed = ", ".join(plural(count, totals.GAP_NOUNS[kind]) for kind, count in counts.items() if count)
    lines = [Line(f"  never imported: {', '.join(code.never_imported)}", "warn")] if code.never_imported else []
    lines += [Line(f"  {file} unmeasured: {why}", "warn") for file, why in sorted(code.unmeasured_files.items())]
    for noun, measured in (("code", "statements"), ("branches", "branches")):
        if any(getattr(suite.code, measured) is None for suite in report.suites):
            lines.append(Line(f"  {noun} unmeasured: {totals.explain_no_coverage(report)}", "warn"))
            break
    by_place: dict[str, list[str]] = {}
    for gap in gaps:
        is_code = gap.kind in ("lines", "branches")
        items = [f"branch {item}" if gap.kind == "branches" else item for item in gap.items]
        by_place.setdefault(gap.place if is_code else f"{gap.place} {gap.kind}", []).extend(items)
    for place, items in by_place.items():
        start = f"  {fit_path(visible(place), columns // 2)}  "
        lines.append(Line(start + listing([visible(item) for item in items], columns - width(start))))
    return [Line(f"{'not covered':{_LABEL}}{listed or _describe_whole(report)}"), *lines]


def _describe_whole(report: Report) -> str:
    """`nothing of 28 statements, 8 branches, 8 plans`, or that it is not known."""
    counts: Counter[str] = Counter()
    for suite in report.suites[:1]:  # all suites have the same
        for noun, measured in (("statement", suite.code.statements), ("branch", suite.code.branches)):
            counts[noun] += measured.reachable if measured else 0
        counts["plan"] += sum(agent.total for agent in suite.plans.values())
        counts["bin"] += suite.cross.possible
    parts = [plural(count, noun) for noun, count in counts.items() if count]
    return f"nothing of {', '.join(parts)}" if parts else "unknown: nothing was measured"
