"""Violations by situation: those of one requirement in one situation are one finding, however many tests have it.

Known ones and others are never one finding: who reads it must not take what is new for what is known.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from pytest_hricdv.monitor import Violation
from pytest_hricdv.report.formatting import by_requirement
from pytest_hricdv.results.model import Report, TestResult


@dataclass(frozen=True)
class FailureGroup:
    """Tests that violated a requirement in the same situation, all as it is known or none.

    Args:
        requirement: its id.
        situation: the bools and texts that were there at the violation, or what was expected; empty where nothing was.
        tests: in the order of their margins, the worst first.
        margin: the worst; None where nothing was compared.
        is_known: these violations are known ones.
    """

    requirement: str
    situation: str
    tests: tuple[TestResult, ...]
    margin: float | None
    is_known: bool


def failure_groups(report: Report) -> tuple[FailureGroup, ...]:
    """Violations that are not known first, then by the number of tests."""
    groups: dict[tuple[str, str, bool], dict[str, tuple[float, TestResult]]] = {}
    for test in report.tests:
        for name, situation, margin, is_known in _violations(report, test):
            tests = groups.setdefault((name, situation, is_known), {})
            tests[test.nodeid] = (min(margin, tests.get(test.nodeid, (math.inf, test))[0]), test)
    return tuple(sorted((_group(*key, [*tests.values()]) for key, tests in groups.items()), key=_order))


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
