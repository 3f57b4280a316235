"""Violations by cause: those of one requirement in the same situation are one finding, however many tests have it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from pytest_hricdv.monitor import Violation
from pytest_hricdv.report.formatting import by_requirement
from pytest_hricdv.results.model import Report, TestResult


@dataclass(frozen=True)
class FailureGroup:
    """Tests that violated a requirement in the same situation.

    Args:
        requirement: its id.
        situation: the bools and texts that were there at the violation, or what was expected; empty where nothing was.
        tests: in the order of their margins, the worst first.
        margin: the worst; None where nothing was compared.
        is_known: all of these violations are known ones.
    """

    requirement: str
    situation: str
    tests: tuple[TestResult, ...]
    margin: float | None
    is_known: bool


def failure_groups(report: Report) -> tuple[FailureGroup, ...]:
    """Violations that are not known first, then by the number of tests."""
    groups: dict[tuple[str, str], dict[str, tuple[float, bool, TestResult]]] = {}
    for test in report.tests:
        for name, situation, margin, is_known in _violations(report, test):
            tests = groups.setdefault((name, situation), {})
            before = tests.get(test.nodeid, (math.inf, True, test))
            tests[test.nodeid] = (min(margin, before[0]), is_known and before[1], test)
    found_groups = [_group(name, situation, list(tests.values())) for (name, situation), tests in groups.items()]
    return tuple(sorted(found_groups, key=_order))


def _order(group: FailureGroup) -> tuple[bool, int, tuple[object, ...], str]:
    return group.is_known, -len(group.tests), by_requirement(group.requirement), group.situation


def _violations(report: Report, test: TestResult) -> Iterator[tuple[str, str, float, bool]]:
    for name, result in test.requirements.items():
        is_known = name in report.known_violations and not report.strict
        for violation in result.violations:
            margin = math.inf if violation.margin is None else violation.margin
            yield name, _situation(violation), margin, is_known and not violation.outside


def _situation(violation: Violation) -> str:
    """What was the case; numbers differ from test to test."""
    plain = ((name, value) for name, value in sorted(violation.values.items()) if isinstance(value, bool | str))
    words = [f"{name} {value}" if isinstance(value, str) else name if value else f"not {name}" for name, value in plain]
    return ", ".join(words)


def _group(name: str, situation: str, tests: list[tuple[float, bool, TestResult]]) -> FailureGroup:
    ordered = sorted(tests, key=lambda entry: (entry[0], entry[2].id))
    worst = ordered[0][0]
    return FailureGroup(
        requirement=name,
        situation=situation,
        tests=tuple(test for _, _, test in ordered),
        margin=worst if math.isfinite(worst) else None,
        is_known=all(is_known for _, is_known, _ in ordered),
    )
