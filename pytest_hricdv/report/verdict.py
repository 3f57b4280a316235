"""The verdict on a whole report, in a line, and what it rests on: what a person asks first."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from pytest_hricdv.report import totals
from pytest_hricdv.report.failure_groups import FailureGroup, failure_groups
from pytest_hricdv.report.formatting import Style, plural
from pytest_hricdv.report.view import FailureCauses, views
from pytest_hricdv.results.model import Report


@dataclass(frozen=True)
class ReportVerdict:
    """What came of a report.

    Args:
        text: `failed: 20 tests, 3 causes; 14 known`.
        style: how good it is.
        causes: what its tests fail for, where somebody looked for it.
        new: violations that are not known, those of one requirement in one situation together.
        known: the same of known ones.
    """

    text: str
    style: Style
    causes: FailureCauses | None
    new: tuple[FailureGroup, ...]
    known: tuple[FailureGroup, ...]


def verdict(report: Report) -> ReportVerdict:
    """The verdict on a report: failed where a test, a gate or the session itself did."""
    groups = failure_groups(report)
    causes = next((causes for view in views() if (causes := view.causes(report, None)) is not None), None)
    why = [*_failed(report, causes)]
    counts = totals.outcomes(report)
    rest = [text for text in (_passed(report) if not why else "", _known(counts["known-violation"], why)) if text]
    ran = sum(counts.values()) - counts["not-run"]
    word = "failed" if why else "passed" if ran else "nothing ran"
    parts = "; ".join(filter(None, [", ".join(why), *rest]))
    return ReportVerdict(
        text=f"{word}: {parts}" if parts else word,
        style="bad" if why else "ok" if ran else "warn",
        causes=causes,
        new=tuple(group for group in groups if not group.is_known),
        known=tuple(group for group in groups if group.is_known),
    )


def _failed(report: Report, causes: FailureCauses | None) -> Iterator[str]:
    failing = sum(test.fails for test in report.tests)
    if failing:
        yield plural(failing, "test")
        new = sum(not cause.is_known for cause in causes.causes) if causes else 0
        if new:
            yield plural(new, "cause")
    gates = totals.failed_gates(report)
    if gates:
        yield plural(len(gates), "gate")
    if report.problems:
        yield plural(len(report.problems), "problem")
    lost = max(report.selected - report.reported, totals.outcomes(report)["not-run"])
    if lost > 0:
        yield f"{plural(lost, 'test')} without a result"


def _passed(report: Report) -> str:
    passed = totals.outcomes(report)["passed"]
    return plural(passed, "test") if passed else ""


def _known(count: int, why: list[str]) -> str:
    return f"{count} known" if why and count else f"{plural(count, 'test')} known to fail" if count else ""
