"""The coverage of tests, one by one and as a suite: code, plans and requirements.

`RunCoverage` is that of one run, `TestCoverage` that of all runs of a test. `results.derivation` gets the figures of a
report from `code_coverage`, `plan_coverage`, `tally` and `curve`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, reduce

from pytest_hricdv.coverage.code_map import Bits, CodeMap, CoverageError, percent
from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.coverage.records import (
    CodeCoverage,
    CurvePoint,
    FileCoverage,
    PlanCoverage,
    PlanReach,
    RequirementTally,
    SuiteCode,
)
from pytest_hricdv.monitor import RequirementResult


@dataclass(frozen=True)
class RunCoverage:
    """The coverage of one run of a test.

    Args:
        code: None if it was not measured.
        plans: agent -> labels of the plans that the test's beliefs triggered.
        beliefs: the beliefs that the test was generated from.
        cross: cross product -> bins, one for each hit.
        requirements: requirement -> verdict; empty if the test was not run.
    """

    id: str
    code: Bits | None
    plans: Mapping[str, frozenset[str]]
    beliefs: tuple[str, ...] = ()
    cross: Mapping[str, tuple[Bin, ...]] = field(default_factory=dict)
    requirements: Mapping[str, RequirementResult] = field(default_factory=dict)


@dataclass(frozen=True)
class TestCoverage:
    """The coverage of all runs of a test: one run, or several different ones in a merged report, whose first represents
    it.

    Args:
        nodeid: the node id of the pytest item.
        runs: at least one.
        sim_s: simulated time of the first run (s).
        was_run: whether the test was run at all.
    """

    __test__ = False

    nodeid: str
    runs: tuple[RunCoverage, ...]
    sim_s: float = 0.0
    was_run: bool = True

    @property
    def id(self) -> str:
        """The test's id."""
        return self.runs[0].id

    @property
    def beliefs(self) -> tuple[str, ...]:
        """The beliefs that the test was generated from."""
        return self.runs[0].beliefs

    @property
    def requirements(self) -> Mapping[str, RequirementResult]:
        """The verdicts that count, from the first run."""
        return self.runs[0].requirements

    @cached_property
    def code(self) -> Bits | None:
        """The code covered by any run; None if none was measured."""
        return union(self.runs)

    @cached_property
    def plans(self) -> Mapping[str, frozenset[str]]:
        """The plans or bins covered by any run."""
        plans: dict[str, frozenset[str]] = {}
        for run in self.runs:
            for agent, labels in run.plans.items():
                plans[agent] = plans.get(agent, frozenset()) | labels
        return plans


def union(tests: Iterable[TestCoverage | RunCoverage]) -> Bits | None:
    """The union of all measured bits, in any order; None when nothing was measured."""
    measured = [test.code for test in tests if test.code is not None]
    return reduce(lambda a, b: a | b, measured) if measured else None


def code_coverage(code: CodeMap, bits: Bits | None) -> SuiteCode:
    """Raw and reachable coverage of statements and branches; None for what was not measured.

    Reachable is all but the waived statements; it does not depend on what tests covered.

    Raises:
        CoverageError: a waived statement ran: the waiver is wrong and must go.
    """
    if bits is None:
        return SuiteCode(statements=None, branches=None)
    waived = code.waiver_bits()
    refuse_broken_waivers(code, bits)
    assert waived.branches is not None
    branches = None
    if bits.branches is not None:
        branches = _coverage(bits.branches, code.branches, waived.branches)
    return SuiteCode(statements=_coverage(bits.statements, code.statements, waived.statements), branches=branches)


def refuse_broken_waivers(code: CodeMap, bits: Bits) -> None:
    """Raises CoverageError when a statement ran that carries `# unreachable`."""
    uncovered = {(file.name, line) for file, lines, _ in code.list_misses(bits) for line in lines}
    for waiver in code.waivers:
        if (waiver.file, waiver.line) not in uncovered:
            raise CoverageError(
                f"{waiver.file}:{waiver.line}: ran, though it is waived as unreachable ({waiver.reason}): "
                "remove the waiver"
            )


def _coverage(bits: int, total: int, waived: int) -> CodeCoverage:
    covered, reachable = bits.bit_count(), total - waived.bit_count()
    return CodeCoverage(
        covered=covered,
        total=total,
        reachable=reachable,
        percent=percent(covered, total),
        percent_reachable=percent((bits & ~waived).bit_count(), reachable),
    )


def file_coverage(code: CodeMap, bits: Bits | None) -> tuple[FileCoverage, ...]:
    """Per file of the code under test: statements, covered, and what is missing; empty when unmeasured."""
    if bits is None:
        return ()
    return tuple(
        FileCoverage(
            file=file.name,
            statements=len(file.statements),
            covered=len(file.statements) - len(lines),
            missing_lines=lines,
            missing_branches=arcs,
        )
        for file, lines, arcs in code.list_misses(bits)
    )


def plan_coverage(tests: Sequence[TestCoverage], declared: Mapping[str, Sequence[str]]) -> dict[str, PlanCoverage]:
    """Per agent: the plans that the tests' beliefs triggered, in source order, and those that none did."""
    coverage = {}
    for agent, plans in declared.items():
        by_plan = {plan: [test for test in tests if plan in test.plans.get(agent, ())] for plan in plans}
        coverage[agent] = PlanCoverage(
            covered=tuple(plan for plan in plans if by_plan[plan]),
            missing=tuple(plan for plan in plans if not by_plan[plan]),
            total=len(plans),
            declared=tuple(plans),
            reached={plan: _reach(reaching) for plan, reaching in by_plan.items() if reaching},
        )
    return coverage


def _reach(tests: Sequence[TestCoverage]) -> PlanReach:
    first = min(tests, key=lambda test: (len(test.beliefs) or math.inf, test.beliefs, test.id))
    return PlanReach(
        tests=len(tests),
        belief_sets=len({test.beliefs for test in tests if test.beliefs}),
        shortest=first.beliefs,
        test=first.id,
    )


def tally(requirement: str, tests: Iterable[TestCoverage]) -> RequirementTally:
    """Assertion coverage: how often one requirement was checked by the tests of a suite, and with which verdicts."""
    results = [test.requirements[requirement] for test in tests if test.was_run]
    verdicts = Counter(result.verdict for result in results)
    return RequirementTally(
        passed=verdicts["Passed"],
        failed=verdicts["Failed"],
        nc=verdicts["NC"],
        triggers=sum(result.triggers for result in results),
        passes=sum(result.passes for result in results),
        failures=sum(result.failures for result in results),
        untriggered=sum(result.untriggered for result in results),
        pending=sum(result.pending for result in results),
        outside=sum(result.outside for result in results),
        vacuous_alternatives=list_vacuous_alternatives(results),
        masked_messages=dict(sum((Counter(result.masked_messages) for result in results), Counter())),
    )


def list_vacuous_alternatives(results: Iterable[RequirementResult]) -> tuple[str, ...]:
    """The alternatives of a requirement's response by which it held in no test that triggered it; none if none did."""
    triggered = [result.vacuous_alternatives for result in results if result.triggers]
    return tuple(text for text in triggered[0] if all(text in unused for unused in triggered)) if triggered else ()


def curve(tests: Iterable[TestCoverage]) -> tuple[CurvePoint, ...]:
    """Cumulative coverage after 1, 2, ... tests in the order of their ids, so that it does not depend on scheduling."""
    points = []
    code: Bits | None = None
    plans: set[tuple[str, str]] = set()
    for number, test in enumerate(sorted(tests, key=lambda test: test.id), 1):
        if test.code is not None:
            code = test.code if code is None else code | test.code
        plans |= {(agent, plan) for agent, labels in test.plans.items() for plan in labels}
        statements = code.statements.bit_count() if code else 0
        branches = (code.branches or 0).bit_count() if code else 0
        points.append(CurvePoint(tests=number, statements=statements, branches=branches, plans=len(plans)))
    return tuple(points)
