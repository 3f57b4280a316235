"""What no test covers: as plain lists for the terminal, and with reasons and suggestions for the page."""

from collections.abc import Iterator
from dataclasses import dataclass

from pytest_hricdv.report import totals
from pytest_hricdv.report.formatting import branches, line_ranges, natural
from pytest_hricdv.report.tests_index import anchor
from pytest_hricdv.results.model import Report

_WAIVED = "waived as unreachable"


@dataclass(frozen=True)
class GapRow:
    """What no test covers of one place: a source file, an agent's plans, a cross product, a requirement.

    `test` is the test that came nearest, as the anchor of a link and an id; None where none is known.
    """

    place: str
    kind: str
    items: tuple[str, ...]
    reason: str = ""
    suggestion: str = ""
    test: tuple[str, str] | None = None


def gaps(report: Report) -> tuple[GapRow, ...]:
    """Everything not covered: lines and branches of each file, then each suite's plans and cross bins.

    Waived lines, and branches from or to them, are left out: they need no test, and are listed as waivers.
    """
    return tuple(gap for gap in (*_code_gaps(report), *_suite_gaps(report)) if gap.items)


def explained_gaps(report: Report) -> tuple[GapRow, ...]:
    """Every gap with its reason and what may close it; gaps that share these are one. Waived lines are left out."""
    anchors = {test.id: anchor(test.nodeid) for test in report.tests}
    grouped: dict[tuple[str, str, str, str, str], list[str]] = {}
    for gap in report.closure.gaps or ():
        if not gap.reason.startswith(_WAIVED):
            grouped.setdefault((gap.place, gap.kind, gap.reason, gap.suggestion, gap.test), []).extend(gap.items)
    return tuple(
        GapRow(place, kind, tuple(items), reason, suggestion, (anchors[test], test) if test in anchors else None)
        for (place, kind, reason, suggestion, test), items in grouped.items()
    )


def _code_gaps(report: Report) -> Iterator[GapRow]:
    waived = {(waiver.file, waiver.line) for waiver in totals.waivers(report)}
    for file in sorted(report.code_under_test.files, key=lambda file: file.file):
        lines = [line for line in file.missing_lines if (file.file, line) not in waived]
        arcs = [arc for arc in file.missing_branches if not any((file.file, line) in waived for line in arc)]
        yield GapRow(file.file, "lines", line_ranges(lines))
        yield GapRow(file.file, "branches", branches(arcs))


def _suite_gaps(report: Report) -> Iterator[GapRow]:
    for suite in report.suites:
        where = f" ({suite.name})" if len(report.suites) > 1 else ""
        for agent in sorted(suite.plans):
            yield GapRow(f"{agent}{where}", "plans", tuple(sorted(suite.plans[agent].missing, key=natural)))
        yield GapRow(f"cross product{where}", "bins", suite.cross.missing)
