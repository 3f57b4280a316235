"""`sheet`: the sign-off sheet for the person who is responsible for a robot, a few printed pages, made by `html`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final

from pytest_hricdv.report import totals
from pytest_hricdv.report.formatting import line_ranges, utc
from pytest_hricdv.report.requirement_view import RequirementView
from pytest_hricdv.report.view import SheetTable, views
from pytest_hricdv.report.waivers_view import Waiver, list_waivers
from pytest_hricdv.results.model import Report
from pytest_hricdv.results.origin import ReportOrigin

MAX_ROWS = 80
"""Most requirements with a row each; beyond it, those that passed are only named. Chosen: with a plan of 30 goals and
20 waivers, 80 rows of two lines are four pages."""

_LINE: Final = "unreachable line"


@dataclass(frozen=True)
class Sheet:
    """The content of the sheet besides the verdict and the figures.

    Attributes:
        date: when the session began; of a merged report, the last one. Empty if nobody knows.
        revision: the project's revision, with a remark where it was changed; of a merged report, each.
        incomplete: why it should not be signed as it is, a sentence each.
        tables: the tables of features, such as the verification plan.
        listed: requirements with a row.
        passed: the names of the others: they passed.
        waivers: the waivers; those on several lines of a file with the same reason are one.
    """

    date: str
    revision: str
    incomplete: tuple[str, ...]
    tables: tuple[SheetTable, ...]
    listed: tuple[RequirementView, ...]
    passed: tuple[str, ...]
    waivers: tuple[Waiver, ...]


def sheet(report: Report, requirements: Sequence[RequirementView], origins: Sequence[ReportOrigin]) -> Sheet:
    """The sheet of a report."""
    is_long = len(requirements) > MAX_ROWS
    named = [view for view in requirements if is_long and view.state == "passed"]
    revisions = dict.fromkeys(
        f"{o.revision[:12]}{' with local changes' if o.dirty else ''}" for o in origins if o.revision
    )
    waived = tuple(_join_lines(list_waivers(report)))
    return Sheet(
        date=utc(max((origin.began for origin in origins), default="")),
        revision=", ".join(revisions),
        incomplete=tuple(_incomplete(report, origins, waived)),
        tables=tuple(table for view in views() if (table := view.of_sheet(report)) is not None),
        listed=tuple(view for view in requirements if view not in named),
        passed=tuple(view.name for view in named),
        waivers=waived,
    )


def _incomplete(report: Report, origins: Sequence[ReportOrigin], waived: Sequence[Waiver]) -> Iterator[str]:
    if lost := totals.loss(report):
        yield lost
    yield from totals.list_vacuity_warnings(report)[:1]
    parts = [suite.name for suite in report.suites if not totals.is_whole(report, suite)]
    if parts:
        yield f"only a part of {', '.join(parts)} was run"
    if not any(origin.revision for origin in origins):
        yield "no revision of the project is known"
    elif any(origin.dirty for origin in origins):
        yield "files differed from the revision"
    if not report.code_under_test.measured:
        yield f"the code is unmeasured: {totals.explain_no_coverage(report)}"
    nobody = sum(not waiver.owner for waiver in waived)
    if nobody:
        yield f"{nobody} of {len(waived)} waivers name no owner"


def _join_lines(single: Sequence[Waiver]) -> Iterator[Waiver]:
    """Lines of a file that are waived for one reason are one row."""
    lines: dict[tuple[str, str, str], list[Waiver]] = {}
    for waiver in single:
        if waiver.kind == _LINE:
            lines.setdefault((waiver.subject.rpartition(":")[0], waiver.reason, waiver.owner), []).append(waiver)
        else:
            yield waiver
    for (file, reason, owner), mine in lines.items():
        numbers = ", ".join(line_ranges(int(waiver.subject.rpartition(":")[2]) for waiver in mine))
        yield Waiver(_LINE, f"{file}:{numbers}", reason, owner, mine[0].until, mine[0].state)


def css_text(text: str) -> str:
    """A text as a string of a style sheet, which can neither end the string nor the element that the sheet is in."""
    plain = "".join(char if char.isalnum() or char in " .,;:()-_+" else f"\\{ord(char):x} " for char in text)
    return f'"{plain}"'
