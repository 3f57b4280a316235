"""The verdict on a report in one line, and its violations grouped by situation.

`html` and `hricdv report live` show the `verdict`. Known violations are never grouped with others: a reader must not
mistake new ones for known ones.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from pytest_hricdv.monitor import Violation
from pytest_hricdv.report import totals
from pytest_hricdv.report.formatting import Style, by_requirement, plural
from pytest_hricdv.report.view import FailureCauses, failure_causes
from pytest_hricdv.results.model import Report, TestResult


@dataclass(frozen=True)
class FailureGroup:
    """Tests that violated a requirement in the same situation, all as it is known or none.

    Args:
        requirement: its id.
        situation: the bools and strings that were there at the violation, or what was expected; empty where nothing
            was.
        tests: the tests, in the order of their margins, the worst first.
        margin: the worst; None where nothing was compared.
        is_known: whether these violations are known ones.
    """

    requirement: str
    situation: str
    tests: tuple[TestResult, ...]
    margin: float | None
    is_known: bool


@dataclass(frozen=True)
class ReportVerdict:
    """The verdict on a report.

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
    causes = failure_causes(report)
    why = [*_describe_failures(report, causes)]
    counts = totals.outcomes(report)
    rest = [
        text
        for text in (_describe_passes(report) if not why else "", _describe_known(counts["known-violation"], why))
        if text
    ]
    ran = sum(counts.values()) - counts["not-run"]
    passes = "passed" if counts["passed"] else "no test passed"
    word = "failed" if why else passes if ran else "nothing ran"
    parts = "; ".join(filter(None, [", ".join(why), *rest]))
    return ReportVerdict(
        text=f"{word}: {parts}" if parts else word,
        style="bad" if why else "ok" if counts["passed"] else "warn",
        causes=causes,
        new=tuple(group for group in groups if not group.is_known),
        known=tuple(group for group in groups if group.is_known),
    )


def _describe_failures(report: Report, causes: FailureCauses | None) -> Iterator[str]:
    failing = sum(test.fails for test in report.tests)
    if failing:
        yield plural(failing, "test")
        new = sum(not cause.is_known for cause in causes.causes) if causes else 0
        if new:
            yield plural(new, "cause")
    gates = totals.list_gate_failures(report)
    if gates:
        yield plural(len(gates), "gate")
    if report.problems:
        yield plural(len(report.problems), "problem")
    lost = max(report.selected - report.reported, totals.outcomes(report)["not-run"])
    if lost > 0:
        yield f"{plural(lost, 'test')} without a result"


def _describe_passes(report: Report) -> str:
    passed = totals.outcomes(report)["passed"]
    return plural(passed, "test") if passed else ""


def _describe_known(count: int, why: list[str]) -> str:
    return f"{count} known" if why and count else f"{plural(count, 'test')} known to fail" if count else ""


def failure_groups(report: Report) -> tuple[FailureGroup, ...]:
    """Violations that are not known first, then by the number of tests."""
    groups: dict[tuple[str, str, bool], dict[str, tuple[float, TestResult]]] = {}
    for test in report.tests:
        for name, situation, margin, is_known in _list_violations(report, test):
            tests = groups.setdefault((name, situation, is_known), {})
            tests[test.nodeid] = (min(margin, tests.get(test.nodeid, (math.inf, test))[0]), test)
    return tuple(sorted((_group(*key, [*tests.values()]) for key, tests in groups.items()), key=_order))


def _order(group: FailureGroup) -> tuple[bool, int, tuple[object, ...], str]:
    return group.is_known, -len(group.tests), by_requirement(group.requirement), group.situation


def _list_violations(report: Report, test: TestResult) -> Iterator[tuple[str, str, float, bool]]:
    for name, result in test.requirements.items():
        is_known = name in report.known_violations and not report.strict
        for violation in result.violations:
            margin = math.inf if violation.margin is None else violation.margin
            yield name, _situation(violation), margin, is_known and not violation.outside


def _situation(violation: Violation) -> str:
    """The situation without its numbers, which differ from test to test."""
    plain = ((name, value) for name, value in sorted(violation.values.items()) if isinstance(value, bool | str))
    words = [f"{name} {value}" if isinstance(value, str) else name if value else f"not {name}" for name, value in plain]
    return ", ".join(words)


def _group(name: str, situation: str, is_known: bool, tests: list[tuple[float, TestResult]]) -> FailureGroup:
    ordered = sorted(tests, key=lambda entry: (entry[0], entry[1].id))
    worst = ordered[0][0]
    return FailureGroup(
        requirement=name,
        situation=situation,
        tests=tuple(test for _, test in ordered),
        margin=worst if math.isfinite(worst) else None,
        is_known=is_known,
    )
