"""Derivation: everything in a report that follows from its declarations and its tests.

`report_builder` and `merging` derive the report of a session and a merged one by the same function, `derive`. So a
merge is exact: it unites tests, and everything about suites and the whole is computed again.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fnmatch import fnmatch

from msgspec.structs import replace

from pytest_hricdv.coverage import gaps
from pytest_hricdv.coverage.closure import PointIndex, closure_summary, cross_closure
from pytest_hricdv.coverage.code_map import Bits, CodeMap, percent
from pytest_hricdv.coverage.cross_product import CrossCoverage
from pytest_hricdv.coverage.records import Closure, Gap, PlanCoverage, ReportedCode, SuiteCode
from pytest_hricdv.coverage.suite_coverage import (
    RunCoverage,
    TestCoverage,
    code_coverage,
    curve,
    file_coverage,
    plan_coverage,
    tally,
    union,
)
from pytest_hricdv.results.model import Report, SuiteResult, TestResult
from pytest_hricdv.results.origin import GenerationResult
from pytest_hricdv.results.section import shares

NO_CLOSURE = Closure(points=0, sim_s=0, growth=(), minimal=(), adds_nothing=(), unique={})
"""The closure of a report that is not derived yet."""


def declare_suite(
    name: str, seed: int, size: int, generation: GenerationResult, plans: Mapping[str, Sequence[str]]
) -> SuiteResult:
    """A suite as declared, with nothing derived yet; `plans` are all plans to cover, by agent."""
    return SuiteResult(
        name=name,
        seed=seed,
        size=size,
        generation=generation,
        plans={
            agent: PlanCoverage(covered=(), missing=(), total=0, declared=tuple(labels), reached={})
            for agent, labels in plans.items()
        },
        tests=0,
        fidelity="",
        requirements={},
        code=SuiteCode(statements=None, branches=None),
        cross=CrossCoverage(bins=0, hit=0, impossible=0, illegal=0, missing=(), products={}),
        curve=(),
        closure=NO_CLOSURE,
    )


def derive(report: Report) -> Report:
    """The report with all that follows from its declarations and its tests; earlier derived values are replaced.

    `code_under_test.reason` stays only where the code was not measured, or not completely.

    Raises:
        CoverageError: a waived statement ran.
    """
    tests = sorted(report.tests, key=lambda test: (test.suite, test.id, test.nodeid))
    covered = {test.nodeid: coverage_of(test) for test in tests}
    not_run = sorted(test.nodeid for test in tests if test.outcome == "not-run")
    code = CodeMap.of(report.code_under_test)
    total = union(covered.values()) if code else None
    suites = [
        _suite(report, suite, code, [test for test in tests if test.suite == suite.name], covered)
        for suite in report.suites
    ]
    closure = closure_summary(_index(report, code), [*covered.values()])
    return replace(
        report,
        selected=len(tests),
        reported=len(tests) - len(not_run),
        not_run=len(not_run),
        not_run_tests=tuple(not_run),
        code_under_test=_code_under_test(report.code_under_test, code, total),
        suites=tuple(suites),
        closure=replace(closure, gaps=tuple(_gaps(report, suites, code, total, [*covered.values()]))),
        tests=tuple(tests),
    )


def coverage_of(test: TestResult) -> TestCoverage:
    """The coverage of a test, with its code as bits again."""
    runs = tuple(
        RunCoverage(
            id=run.id,
            code=Bits.of(run.code),
            plans={agent: frozenset(labels) for agent, labels in run.plans.items()},
            beliefs=run.beliefs,
            cross=run.cross or {},
            requirements=run.requirements,
        )
        for run in test.runs
    )
    return TestCoverage(test.nodeid, runs, test.sim_s, was_run=test.outcome != "not-run")


def _code_under_test(declared: ReportedCode, code: CodeMap | None, total: Bits | None) -> ReportedCode:
    complete = total is not None and total.branches is not None
    files = file_coverage(code, total) if code else ()
    unmeasured = {**declared.unmeasured_files, **(dict(reversed(total.unmeasured)) if total is not None else {})}
    return replace(
        declared,
        measured=total is not None,
        reason="" if complete else declared.reason,
        files=files,
        # An import runs at least one statement, if there is one.
        never_imported=tuple(
            file.file for file in files if file.statements and not file.covered and file.file not in unmeasured
        ),
        unmeasured_files=unmeasured,
    )


def _suite(
    report: Report,
    suite: SuiteResult,
    code: CodeMap | None,
    tests: Sequence[TestResult],
    covered: Mapping[str, TestCoverage],
) -> SuiteResult:
    mine = [covered[test.nodeid] for test in tests]
    return replace(
        suite,
        tests=len(mine),
        fidelity=" and ".join(sorted({test.fidelity for test in tests} - {""})),
        engine=" and ".join(sorted({engine for test in tests for engine in test.engines})),
        requirements={name: tally(name, mine) for name in report.requirements},
        code=code_coverage(code, union(mine)) if code else SuiteCode(statements=None, branches=None),
        plans=plan_coverage(mine, {agent: plans.declared for agent, plans in suite.plans.items()}),
        cross=cross_closure(report.cross_products, [run for test in mine for run in test.runs]),
        curve=curve(mine),
        closure=closure_summary(_index(report, code), mine),
    )


def _index(report: Report, code: CodeMap | None) -> PointIndex:
    illegal = {name: [record.bin for record in product.illegal] for name, product in report.cross_products.items()}
    return PointIndex(code.statements if code else 0, code.branches if code else 0, illegal)


def _gaps(
    report: Report,
    suites: Iterable[SuiteResult],
    code: CodeMap | None,
    total: Bits | None,
    tests: Sequence[TestCoverage],
) -> list[Gap]:
    """The gaps that no test of any suite covers."""
    runs = [run for test in tests for run in test.runs]
    products = cross_closure(report.cross_products, runs).products
    missing = {name: product.missing for name, product in products.items()}
    declared = {agent: plans.declared for suite in suites for agent, plans in suite.plans.items()}
    return [
        *(gaps.code_gaps(code, total, runs) if code and total else ()),
        *gaps.plan_gaps(declared, runs, report.exploration),
        *gaps.bin_gaps(report.cross_products, missing, report.exploration),
        *gaps.requirement_gaps(report.requirements, tests),
    ]


def percentages(report: Report, kind: str) -> list[tuple[str, float | None]]:
    """Per suite, the percentage that a threshold of this kind is compared with; None where nothing was measured.

    Statements and branches: of what is reachable. Plans: of suites that a model generated. Assertions: requirements
    that were checked. Cross: of what is possible. Kinds of features: see
    `results.section.Share`.
    """
    suites = report.suites
    for share in shares():
        if kind == share.kind:
            return [(suite.name, share.percent(report, suite.name)) for suite in suites]
    if kind == "plans":
        suites = tuple(suite for suite in suites if suite.plans) or suites
    return [(suite.name, _percentage(suite, kind)) for suite in suites]


def _percentage(suite: SuiteResult, kind: str) -> float | None:
    if kind in ("statements", "branches"):
        coverage = suite.code.statements if kind == "statements" else suite.code.branches
        return None if coverage is None else float(coverage.percent_reachable)
    if kind == "plans":
        plans = suite.plans.values()
        covered, total = sum(len(agent.covered) for agent in plans), sum(agent.total for agent in plans)
        return percent(covered, total) if plans else None
    if kind == "assertions":
        tallies = suite.requirements.values()
        checked = sum(tally.passed + tally.failed > 0 for tally in tallies)
        return percent(checked, len(tallies)) if tallies else None
    return percent(suite.cross.hit, suite.cross.possible) if suite.cross.bins else None


def code_covered(report: Report, kind: str, globs: Iterable[str] = ()) -> tuple[int, int]:
    """Hit and reachable statements or branches of files, over all suites."""
    code, chosen = report.code_under_test, tuple(globs)
    if not code.measured:
        return 0, 0
    waived = {(waiver.file, waiver.line) for waiver in code.waivers}
    hit = total = 0
    covered = {file.file: file for file in code.files}
    for file in code.map:
        if file.file not in covered or (chosen and not any(fnmatch(file.file, glob) for glob in chosen)):
            continue
        every: set[tuple[int, ...]] = {(line,) for line in file.statements}
        missing: set[tuple[int, ...]] = {(line,) for line in covered[file.file].missing_lines}
        if kind == "branches":
            every = {tuple(arc) for arc in file.branches}
            missing = {tuple(arc) for arc in covered[file.file].missing_branches}
        counted = {point for point in every if not any((file.file, line) in waived for line in point)}
        total += len(counted)
        hit += len(counted - missing)
    return hit, total
