"""Totals over a report, such as `outcomes`, `requirement_rows` and `gaps`; all views take their figures from here."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import groupby
from operator import attrgetter, itemgetter
from typing import Literal

from pytest_hricdv._base.message import list_names
from pytest_hricdv.coverage.cross_product import CrossCoverage
from pytest_hricdv.coverage.gaps import near_miss
from pytest_hricdv.coverage.records import WaiverRecord
from pytest_hricdv.execution.outcome import FAILING, XFAILED, TestOutcome
from pytest_hricdv.report.formatting import branches, by_requirement, line_ranges, natural, plural, share
from pytest_hricdv.report.holes import holes_of_suite
from pytest_hricdv.report.view import views
from pytest_hricdv.report.violations import margin_unit
from pytest_hricdv.results.gates import xfail_text
from pytest_hricdv.results.model import Report, SuiteResult, TestResult

_OUTCOME_WORDS: Mapping[TestOutcome, tuple[str, str]] = {
    "passed": ("passed", "passed"),
    "failed": ("failed", "failed"),
    "known-violation": ("known violation", "known to fail"),
    "engine-sensitive": ("engine-sensitive", "engine-sensitive"),
    "expected-failure": ("xfailed by the test function", "xfailed by the test function"),
    "error": ("error", "in error"),
    "not-run": ("not run", "not run"),
}
"""The words for one test and for several, in the order of listing."""

GapKind = Literal["lines", "branches", "plans", "bins"]

GAP_NOUNS: Mapping[GapKind, str] = {"lines": "statement", "branches": "branch", "plans": "plan", "bins": "bin"}
"""The noun counted for each kind, code first."""


@dataclass(frozen=True)
class RequirementRow:
    """One requirement over one suite: tests by verdict, triggers over all tests, and the least margin.

    `pending` are the triggers that were undecided at the end of a run.

    `known_reason` is why its violation is known, with its condition; empty if it is not, or if the run is strict.
    `outside` counts failed tests with a violation outside of that condition. `allowed_untriggered` is the reason why
    no test of this suite need trigger it; empty if one must. `vacuous_alternatives` are the alternatives of its
    response by which it never held. `masked_messages` counts, by topic, the messages that were not evaluated because
    another one came at the same instant.
    `margin` is the least over the suite's tests, in its unit.
    """

    name: str
    title: str
    group: str
    passed: int
    failed: int
    nc: int
    triggers: int
    pending: int
    known_reason: str
    outside: int
    allowed_untriggered: str
    vacuous_alternatives: tuple[str, ...]
    masked_messages: Mapping[str, int]
    margin: float | None
    unit: str

    @property
    def is_tolerated(self) -> bool:
        """Whether it failed, and only where its violation is known."""
        return bool(self.failed and self.known_reason and not self.outside)

    @property
    def xfail_note(self) -> str:
        """Why and where its violation is known, and in how many tests it is violated elsewhere."""
        elsewhere = f"; {plural(self.outside, 'test')} violated it outside of this condition" if self.outside else ""
        return f"{self.known_reason}{elsewhere}"


@dataclass(frozen=True)
class SessionDuration:
    """Wall-clock seconds of the session, and simulated seconds over all its tests."""

    wall_s: float
    simulated_s: float
    workers: int

    @property
    def speed(self) -> float | None:
        """How many times real time; None if the wall clock shows no time."""
        return self.simulated_s / self.wall_s if self.wall_s > 0 else None


@dataclass(frozen=True)
class GapRow:
    """The gaps of one place: a source file, an agent's plans, a cross product.

    `items` are ranges of lines, branches, plans, or groups of bins; `count` is how many lines, branches, plans or bins.
    """

    place: str
    kind: GapKind
    items: tuple[str, ...]
    count: int


def outcomes(report: Report) -> dict[TestOutcome, int]:
    """Number of tests by outcome, with every outcome.

    A test without a result counts as `not-run` whether or not the report lists it as a test.
    """
    counts: Counter[TestOutcome] = Counter(test.outcome for test in report.tests)
    counts["not-run"] = max(counts["not-run"], report.not_run)
    return {name: counts[name] for name in _OUTCOME_WORDS}


def outcome_word(outcome: TestOutcome) -> str:
    """The word for a test with this outcome."""
    return _OUTCOME_WORDS[outcome][0]


def outcome_style(outcome: TestOutcome) -> str:
    """How good it is, as views colour it: `ok`, `warn`, `bad`, or nothing."""
    if outcome in FAILING:
        return "bad"
    return "warn" if outcome in XFAILED else "ok" if outcome == "passed" else ""


def has_failed(report: Report) -> bool:
    """Whether a test failed."""
    return any(test.fails for test in report.tests)


def outcomes_text(report: Report) -> str:
    """`120 passed, 14 known to fail`: the outcomes of all tests that ran."""
    counts = [(count, _OUTCOME_WORDS[name][1]) for name, count in outcomes(report).items() if name != "not-run"]
    return ", ".join(f"{count} {word}" for count, word in counts if count) or "nothing run"


def loss(report: Report) -> str:
    """How many tests have no result; empty when every selected test was reported."""
    missing = report.selected - report.reported
    if missing < 0:
        return f"{plural(-missing, 'result')} more than tests: counted twice?"
    missing = max(missing, report.not_run)
    return f"{plural(missing, 'test')} not run or lost, totals are lower bounds" if missing else ""


def is_whole(report: Report, suite: SuiteResult) -> bool:
    """Whether all tests of a suite were run."""
    run = {test.id for test in report.tests if test.suite == suite.name and test.outcome != "not-run"}
    return len(run) == suite.size


def tests_text(report: Report, suite: SuiteResult) -> str:
    """`134 tests, 131 not run`: how many tests a suite has, and how many of them have no verdicts.

    Of a part of the suite: `3 of 134 tests`.
    """
    not_run = sum(test.suite == suite.name and test.outcome == "not-run" for test in report.tests)
    part = f"{suite.tests} of " if suite.tests < suite.size else ""
    return part + plural(suite.size if part else suite.tests, "test") + (f", {not_run} not run" if not_run else "")


def list_gate_failures(report: Report) -> tuple[str, ...]:
    """Gate failures: the reasons besides tests why the run failed, a sentence each."""
    return report.gates.failed if report.gates else ()


def list_vacuity_warnings(report: Report) -> tuple[str, ...]:
    """Warnings that tests passed without triggering any requirement, and advice, a sentence each."""
    passed = [test for test in report.tests if test.outcome == "passed"]
    if not passed or any(count.triggers for suite in report.suites for count in suite.requirements.values()):
        return ()
    names = sorted(report.requirements, key=by_requirement)
    ran = plural(len(passed), "test")
    if not names:
        return (f"nothing was checked: the testbench has no requirement, so {ran} passed vacuously",)
    return (
        f"nothing was checked: no test triggered a requirement ({list_names(names, 5)}), so {ran} passed vacuously",
        *_nearest(report, names),
        "see in the report what was published and recorded in a run: a message or signal that is missing there, or an "
        "antecedent that asks for more than happens",
        *(["with --hri-fail-on=nc, this fails the session"] if _would_fail(report, names) else []),
    )


def _would_fail(report: Report, names: Iterable[str]) -> bool:
    """Whether `--hri-fail-on=nc` would fail a session that checked nothing: of a part of the suites it does not."""
    is_of_suites = bool(report.rerun_options.suite) and not report.shard
    suites = frozenset(suite.name for suite in report.suites)
    has_to_be_checked = any(not find_exemption(report, name, suites) for name in names)
    is_complete = is_of_suites and all(is_whole(report, suite) for suite in report.suites)
    return is_complete and has_to_be_checked and not list_gate_failures(report)


def _nearest(report: Report, names: Iterable[str]) -> Iterator[str]:
    """The condition that was missing when a requirement was closest to being triggered."""
    misses = []
    for name in names:
        results = ((test.id, test.requirements[name]) for test in report.tests if name in test.requirements)
        test, missing = near_miss(results)
        misses += [(len(missing), name, test, missing)] if test else []
    if misses:
        _, name, test, missing = min(misses, key=itemgetter(0))
        yield f"nearest was {name} in {test}, which lacked {' & '.join(missing)}"


def join_rows(report: Report) -> list[RequirementRow]:
    """One row for each requirement, over all suites."""
    rows: dict[str, RequirementRow] = {}
    suites = frozenset(suite.name for suite in report.suites)
    for suite in report.suites:
        for row in requirement_rows(report, suite):
            above = rows.get(row.name)
            if above is None:
                rows[row.name] = replace(row, allowed_untriggered=find_exemption(report, row.name, suites))
                continue
            counts = {
                name: getattr(above, name) + getattr(row, name)
                for name in ("passed", "failed", "nc", "triggers", "pending", "outside")
            }
            margins = [margin for margin in (above.margin, row.margin) if margin is not None]
            rows[row.name] = replace(above, **counts, margin=min(margins, default=None))
    return [*rows.values()]


def requirement_rows(report: Report, suite: SuiteResult) -> tuple[RequirementRow, ...]:
    """A suite's requirements, R2 before R10; those of a group together, and first those of none."""
    rows = []
    for name in sorted(suite.requirements, key=by_requirement):
        tally = suite.requirements[name]
        margin = _least_margin(report, suite.name, name)
        rows.append(
            RequirementRow(
                name=name,
                title=report.requirements[name].title if name in report.requirements else "",
                group=report.requirements[name].group if name in report.requirements else "",
                passed=tally.passed,
                failed=tally.failed,
                nc=tally.nc,
                triggers=tally.triggers,
                pending=tally.pending,
                known_reason=find_xfail_reason(report, name),
                outside=tally.outside,
                vacuous_alternatives=tally.vacuous_alternatives,
                masked_messages=tally.masked_messages,
                allowed_untriggered=find_exemption(report, name, frozenset({suite.name})),
                margin=margin,
                unit=margin_unit(report, name),
            )
        )
    first = {row.group: place for place, row in reversed([*enumerate(rows)])}
    return tuple(sorted(rows, key=lambda row: (row.group != "", first[row.group])))


def by_group(rows: Iterable[RequirementRow]) -> Iterator[tuple[str, Iterator[RequirementRow]]]:
    """The groups of requirements, each with its rows; where none was given, a single group without a name."""
    return groupby(rows, key=attrgetter("group"))


def find_xfail_reason(report: Report, requirement: str) -> str:
    """Why, and under which condition, violations of a requirement are known; empty if they are not, or in strict."""
    if report.strict or requirement not in report.known_violations:
        return ""
    return xfail_text(report.known_violations[requirement] or "known", report.known_when.get(requirement, ""))


def find_exemption(report: Report, requirement: str, suites: frozenset[str]) -> str:
    """Why a requirement need not be triggered in any of these suites; empty if it must be."""
    exemption = report.allowed_untriggered.get(requirement)
    return exemption.reason if exemption and suites.issubset(exemption.suites or suites) else ""


def is_tolerated(report: Report, requirement: str, test: TestResult) -> bool:
    """Whether a test that violates the requirement does so only where that is known."""
    return bool(find_xfail_reason(report, requirement)) and not test.requirements[requirement].outside


def duration(report: Report) -> SessionDuration:
    """The session's wall clock, and the simulated time of its tests; of a campaign, that of all runs."""
    of_all_runs = [total_s for view in views() if (total_s := view.total_simulated_s(report)) is not None]
    simulated_s = of_all_runs[0] if of_all_runs else sum(test.sim_s for test in report.tests)
    return SessionDuration(report.wall_s, simulated_s, report.workers)


def explain_no_coverage(report: Report) -> str:
    """Why the code was not measured, for a suite without figures of it."""
    return report.code_under_test.reason or ("no reason given" if report.tests else "no test ran")


def waivers(report: Report) -> tuple[WaiverRecord, ...]:
    """Lines of the code under test declared unreachable, by file and line."""
    return tuple(sorted(report.code_under_test.waivers, key=lambda waiver: (waiver.file, waiver.line)))


def plans_covered(suite: SuiteResult) -> float | None:
    """The percentage of all agents' plans; None if the suite was generated without a model."""
    plans = suite.plans.values()
    return share(sum(len(agent.covered) for agent in plans), sum(agent.total for agent in plans))


def bins_covered(cross: CrossCoverage) -> float | None:
    """The percentage of the bins that are neither impossible nor illegal; None if there are none."""
    return share(cross.hit, cross.possible)


def gaps(report: Report) -> tuple[GapRow, ...]:
    """Everything not covered: lines and branches of each file, then each suite's plans and cross bins.

    Waived lines, and branches from or to them, are left out: they need no test, and are listed as waivers.
    """
    return tuple(gap for gap in (*_code_gaps(report), *_suite_gaps(report)) if gap.items)


def _least_margin(report: Report, suite: str, requirement: str) -> float | None:
    margins = [
        result.margin
        for test in report.tests
        if test.suite == suite and (result := test.requirements.get(requirement)) is not None
        if result.margin is not None
    ]
    return min(margins, default=None)


def _code_gaps(report: Report) -> Iterator[GapRow]:
    waived = {(waiver.file, waiver.line) for waiver in waivers(report)}
    for file in sorted(report.code_under_test.files, key=lambda file: file.file):
        if file.file in report.code_under_test.never_imported:  # said by itself
            continue
        lines = [line for line in file.missing_lines if (file.file, line) not in waived]
        arcs = [arc for arc in file.missing_branches if not any((file.file, line) in waived for line in arc)]
        yield GapRow(file.file, "lines", line_ranges(lines), len(lines))
        yield GapRow(file.file, "branches", branches(arcs), len(arcs))


def _suite_gaps(report: Report) -> Iterator[GapRow]:
    for suite in report.suites:
        where = f" ({suite.name})" if len(report.suites) > 1 else ""
        for agent in sorted(suite.plans):
            missing = suite.plans[agent].missing
            yield GapRow(f"{agent}{where}", "plans", tuple(sorted(missing, key=natural)), len(missing))
        bins = max(suite.cross.possible - suite.cross.hit, 0)
        yield GapRow(f"cross product{where}", "bins", tuple(holes_of_suite(report, suite)), bins)
