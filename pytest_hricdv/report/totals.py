"""Sums over a report, computed in one place so that the terminal and the page cannot disagree."""

from collections import Counter
from dataclasses import dataclass

from pytest_hricdv.coverage.records import CrossCoverage, WaiverRecord
from pytest_hricdv.report.formatting import natural, plural, share
from pytest_hricdv.results.model import Report, SuiteResult

OUTCOMES = ("passed", "failed", "known-violation", "error", "not-run")
_OUTCOME_WORDS = {"passed": "passed", "failed": "failed", "known-violation": "known to fail", "error": "in error"}


@dataclass(frozen=True)
class RequirementRow:
    """One requirement over one suite: tests by verdict, triggers over all tests, and the least margin.

    `known` is the reason why its violation is known; empty if it is not, or if the run is strict.
    `margin` is the least over the suite's tests, in the requirement's own unit; `margin_test` is the test that had it.
    """

    name: str
    title: str
    passed: int
    failed: int
    nc: int
    triggers: int
    known: str
    margin: float | None
    margin_test: str


@dataclass(frozen=True)
class Duration:
    """Wall-clock seconds of the session, and simulated seconds over all its tests."""

    wall_s: float
    simulated_s: float
    workers: int

    @property
    def speed(self) -> float | None:
        """How many times real time; None if the wall clock shows no time."""
        return self.simulated_s / self.wall_s if self.wall_s > 0 else None


def outcomes(report: Report) -> dict[str, int]:
    """Number of tests by outcome, with every outcome.

    A test without a result counts as `not-run` whether or not the report lists it as a test.
    """
    counts: Counter[str] = Counter(test.outcome for test in report.tests)
    counts["not-run"] = max(counts["not-run"], report.not_run)
    return {name: counts[name] for name in OUTCOMES}


def outcomes_text(report: Report) -> str:
    """`120 passed, 14 known to fail`: the outcomes of all tests that ran."""
    counts = outcomes(report)
    return ", ".join(f"{counts[name]} {word}" for name, word in _OUTCOME_WORDS.items() if counts[name]) or "nothing run"


def loss(report: Report) -> str:
    """How many tests have no result; empty when every selected test was reported."""
    missing = report.selected - report.reported
    if missing < 0:
        return f"{plural(-missing, 'result')} more than tests: counted twice?"
    missing = max(missing, report.not_run)
    return f"{plural(missing, 'test')} not run or lost, totals are lower bounds" if missing else ""


def failed_gates(report: Report) -> tuple[str, ...]:
    """What failed the run beside its tests, a sentence each."""
    return report.gates.failed if report.gates else ()


def requirement_rows(report: Report, suite: SuiteResult) -> tuple[RequirementRow, ...]:
    """A suite's requirements, R2 before R10."""
    reasons = {} if report.strict else report.known_violations
    rows = []
    for name in sorted(suite.requirements, key=natural):
        tally = suite.requirements[name]
        margin, test = _least_margin(report, suite.name, name)
        rows.append(
            RequirementRow(
                name=name,
                title=report.requirements[name].title if name in report.requirements else "",
                passed=tally.passed,
                failed=tally.failed,
                nc=tally.nc,
                triggers=tally.triggers,
                known=(reasons[name] or "known") if name in reasons else "",
                margin=margin,
                margin_test=test,
            )
        )
    return tuple(rows)


def duration(report: Report) -> Duration:
    """The session's wall clock, and the simulated time of its tests."""
    return Duration(report.wall_s, sum(test.sim_s for test in report.tests), report.workers or 1)


def statements_covered(report: Report) -> tuple[int, int]:
    """Statements covered by all suites together, and all statements."""
    files = report.code_under_test.files
    return sum(file.covered for file in files), sum(file.statements for file in files)


def unmeasured(report: Report) -> str:
    """Why the code was not measured, for a suite without figures of it."""
    return report.code_under_test.reason or "no reason given"


def waivers(report: Report) -> tuple[WaiverRecord, ...]:
    """Lines of the code under test declared unreachable, by file and line."""
    return tuple(sorted(report.code_under_test.waivers, key=lambda waiver: (waiver.file, waiver.line)))


def plans_covered(suite: SuiteResult) -> float | None:
    """Of all agents' plans, per cent; None if the suite was generated without a model."""
    plans = suite.plans.values()
    return share(sum(len(each.covered) for each in plans), sum(each.total for each in plans))


def bins_covered(cross: CrossCoverage) -> float | None:
    """Of the bins that are neither impossible nor illegal, per cent; None if there is none."""
    return share(cross.hit, cross.possible)


def _least_margin(report: Report, suite: str, requirement: str) -> tuple[float | None, str]:
    margins = [
        (result.margin, test.id)
        for test in report.tests
        if test.suite == suite and (result := test.requirements.get(requirement)) is not None
        if result.margin is not None
    ]
    return min(margins) if margins else (None, "")
