"""The page's index of tests: one short row per test, from which the browser makes its tables, plots and searches."""

from collections.abc import Mapping, Sequence
from hashlib import sha256
from typing import Any

from pytest_hricdv.report.formatting import natural
from pytest_hricdv.results.model import Report, TestResult

_LETTERS = {"Passed": "P", "Failed": "F", "NC": "N"}
PlanName = tuple[str, str]
"""Agent and label."""


def index(report: Report) -> dict[str, Any]:
    """The rows, and the names that they refer to by number, as plain data.

    Returns:
        `requirements`, `suites`, `plans` ([agent, label] each): names. `rows`: a list per test, in the order of the
        report's tests; `data.js` says what stands at which position.
    """
    requirements = requirement_names(report)
    suites = [suite.name for suite in report.suites]
    suites += sorted({test.suite for test in report.tests} - set(suites))
    plans = plan_names(report)
    numbers = {plan: number for number, plan in enumerate(plans)}
    rows = [_row(test, requirements, suites.index(test.suite), numbers) for test in report.tests]
    return {"requirements": requirements, "suites": suites, "plans": plans, "rows": rows}


def requirement_names(report: Report) -> list[str]:
    """Every requirement that a test or the report names, R2 before R10."""
    names = {name for test in report.tests for name in test.requirements}
    return sorted(names | set(report.requirements), key=natural)


def plan_names(report: Report) -> list[PlanName]:
    """All coverage plans of all suites."""
    found: dict[PlanName, None] = {}
    for suite in report.suites:
        for agent in sorted(suite.plans):
            labels = sorted({*suite.plans[agent].covered, *suite.plans[agent].missing}, key=natural)
            found.update(dict.fromkeys((agent, label) for label in labels))
    return list(found)


def code_bits(test: TestResult) -> tuple[int, int]:
    """The statements and branches that a test covered, bit n for the n-th of the sources; 0 where unmeasured."""
    statements, branches = test.code.bits if test.code else (None, None)
    return int(statements or "0", 16), int(branches or "0", 16)


def plan_bits(test: TestResult, numbers: Mapping[PlanName, int]) -> int:
    """The coverage plans that a test's beliefs triggered, as a bit set."""
    plans = {(agent, label) for agent, labels in test.plans.items() for label in labels}
    return sum(1 << numbers[plan] for plan in plans if plan in numbers)


def anchor(nodeid: str) -> str:
    """A test's name in links: a digest of the node id, which may hold characters that an address may not."""
    return sha256(nodeid.encode("utf-8", "backslashreplace")).hexdigest()[:10]


def _row(test: TestResult, requirements: Sequence[str], suite: int, plans: Mapping[PlanName, int]) -> list[Any]:
    """What `data.js` reads by position."""
    results = [test.requirements.get(name) for name in requirements]
    return [
        anchor(test.nodeid),
        test.id,
        suite,
        test.outcome,
        "".join(_LETTERS[each.verdict] if each else "-" for each in results),
        [each.triggers if each else 0 for each in results],
        [_rounded(each.margin) if each else None for each in results],
        test.outcomes,
        _rounded(test.code.percent) if test.code else None,
        _rounded(test.sim_s),
        " ".join(test.beliefs),
        f"{code_bits(test)[0]:x}",
        f"{plan_bits(test, plans):x}",
    ]


def _rounded(value: float | None) -> float | None:
    """Five digits are more than any table or plot shows."""
    return None if value is None else float(f"{value:.5g}")
