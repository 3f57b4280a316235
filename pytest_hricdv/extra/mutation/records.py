"""Records of mutation testing: the trials of each mutant of the code under test (`MutantResult`), and the scores.

`MutationRun` makes them, with `score_mutants`; `MutationView` shows them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Literal

from msgspec import Struct

from pytest_hricdv._base.record import Count, Names, NotNegative, Percent, PlainRecord
from pytest_hricdv.coverage.code_map import percent
from pytest_hricdv.results.section import Section, Share

EXCEPTION, ENDING, BIN = "exception", "ending", "bin"
"""Oracles besides requirements: code raised an exception; the run did not end, or in a way that the testbench does not
allow; the run hit a bin that it cannot or must not hit."""

MutationEnd = Literal["done", "seconds", "interrupted", "lost"]
MutantStatus = Literal["killed", "survived", "unchanged", "no coverage", "not run"]
"""Killed: some test fails. Survived: a record changed, and no test fails. Unchanged: no record changed. No coverage: no
test executes the statement. Not run: time ran out before, or before all of its tests had run."""


class MutantRun(PlainRecord, frozen=True, kw_only=True):
    """One test run with a mutant.

    Args:
        assertions: those that failed: requirements without known violations, and the oracles of this module.
        changed: whether the record differs from that in the original code.
        note: problems besides requirements.
    """

    test: str
    suite: str
    assertions: Names
    changed: bool
    note: str = ""


class MutantResult(PlainRecord, frozen=True, kw_only=True):
    """A mutant and its trials.

    Args:
        id: the mutant's id, from its content.
        file: the file that was changed.
        line: the first line that differs.
        operator: what was done.
        before: the lines that differ.
        after: what they became.
        status: what became of it in all tests together.
        executing: suite -> how many of its tests execute the statement.
        runs: the runs, in the order in which they were tried.
        complete: whether all runs that were planned were done, or not needed any more.
        difference: for a mutant that survived, the first difference of a test's behaviour.
    """

    id: str
    file: str
    line: Count
    operator: str
    before: str
    after: str
    executing: Mapping[str, Count]
    runs: tuple[MutantRun, ...]
    complete: bool
    status: MutantStatus
    difference: str = ""

    def status_in(self, suite: str) -> MutantStatus:
        """Its status in the tests of one suite."""
        runs = [run for run in self.runs if run.suite == suite]
        return mutant_status(runs, executed=suite in self.executing, complete=self.complete)

    @property
    def assertions(self) -> frozenset[str]:
        """Everything that failed in any run."""
        return frozenset(oracle for run in self.runs for oracle in run.assertions)


def mutant_status(runs: Iterable[MutantRun], *, executed: bool, complete: bool) -> MutantStatus:
    """The status of a mutant in these runs.

    Args:
        executed: whether a test executes its statement.
        complete: whether all runs that were planned were done, or not needed any more.
    """
    runs = list(runs)
    if any(run.assertions for run in runs):
        return "killed"
    if not executed:
        return "no coverage"
    if not complete:
        return "not run"
    return "survived" if any(run.changed for run in runs) else "unchanged"


class MutationScore(PlainRecord, frozen=True, kw_only=True):
    """The number of mutants by status. `percent` is the share of killed ones among those tried."""

    mutants: Count
    killed: Count
    survived: Count
    unchanged: Count
    no_coverage: Count
    not_run: Count
    percent: Percent | None


class OracleScore(PlainRecord, frozen=True, kw_only=True):
    """The number of mutants that an oracle, or a group of them, killed; and that no other one killed in these runs."""

    killed: Count
    killed_only_by: Count


class MutationResult(PlainRecord, frozen=True, kw_only=True):
    """The result of trying mutants.

    Args:
        mutants: the mutants, in the order of files and lines.
        generated: how many there are; more than `mutants` where only some were drawn.
        seed: the seed that the order of trials was drawn with.
        tests_per_mutant: most tests of a suite on which a mutant was tried; None: all that execute it.
        matrix: whether a mutant was tried on further tests after one failed.
        excluded_tests: tests that fail, or were not measured, in the original code.
        processes: number of processes that made the runs.
        total: the score of all tests together.
        operators: operator -> the score of its mutants.
        assertions: oracle -> its score; requirements that killed none have one, too.
        groups: group of requirements -> its score.
    """

    mutants: tuple[MutantResult, ...]
    generated: Count
    seed: int
    tests_per_mutant: Count | None
    matrix: bool
    excluded_tests: Names
    processes: Count
    wall_s: NotNegative
    end_reason: MutationEnd
    total: MutationScore
    suites: Mapping[str, MutationScore]
    operators: Mapping[str, MutationScore]
    assertions: Mapping[str, OracleScore]
    groups: Mapping[str, OracleScore]


def score_mutants(
    *,
    mutants: tuple[MutantResult, ...],
    made: int,
    seed: int,
    tests_per_mutant: int | None,
    matrix: bool,
    excluded_tests: Names,
    processes: int,
    wall_s: float,
    ended: MutationEnd,
    requirements: Mapping[str, str],
) -> MutationResult:
    """The result with its scores; the arguments are its fields, and the group of each requirement, which may be ""."""
    suites = sorted({suite for mutant in mutants for suite in mutant.executing})
    operators = sorted({mutant.operator for mutant in mutants})

    def members(group: str) -> list[str]:
        return [name for name, other in requirements.items() if other == group]

    others = sorted({oracle for mutant in mutants for oracle in mutant.assertions} - {*requirements})
    return MutationResult(
        mutants=mutants,
        generated=made,
        seed=seed,
        tests_per_mutant=tests_per_mutant,
        matrix=matrix,
        excluded_tests=excluded_tests,
        processes=processes,
        wall_s=wall_s,
        end_reason=ended,
        total=_score([mutant.status for mutant in mutants]),
        suites={name: _score([mutant.status_in(name) for mutant in mutants]) for name in suites},
        operators={
            name: _score([mutant.status for mutant in mutants if mutant.operator == name]) for name in operators
        },
        assertions=_oracles(mutants, {name: [name] for name in (*requirements, *others)}),
        groups=_oracles(mutants, {group: members(group) for group in dict.fromkeys(requirements.values()) if group}),
    )


def _score(statuses: Sequence[MutantStatus]) -> MutationScore:
    tried = len(statuses) - statuses.count("not run")
    return MutationScore(
        mutants=len(statuses),
        killed=statuses.count("killed"),
        survived=statuses.count("survived"),
        unchanged=statuses.count("unchanged"),
        no_coverage=statuses.count("no coverage"),
        not_run=statuses.count("not run"),
        percent=percent(statuses.count("killed"), tried) if tried else None,
    )


def _oracles(mutants: Iterable[MutantResult], groups: Mapping[str, Collection[str]]) -> dict[str, OracleScore]:
    """Name -> how many mutants the oracles of this name killed, and how many nothing else killed."""
    failed = [mutant.assertions for mutant in mutants if mutant.assertions]
    return {
        name: OracleScore(
            killed=sum(not oracles.isdisjoint(members) for oracles in failed),
            killed_only_by=sum(oracles <= {*members} for oracles in failed),
        )
        for name, members in groups.items()
    }


MUTATION: Section[MutationResult | None] = Section("mutation", MutationResult | None, None)
"""The result of a session that mutated the code under test; a merged report has none."""

SECTIONS = (MUTATION,)


def _percent(report: Struct, suite: str) -> float | None:
    result = MUTATION.of(report)
    return result.suites[suite].percent if result is not None and suite in result.suites else None


SHARES = (Share("mutants", _percent, lambda report: MUTATION.of(report) is not None),)
"""The mutants that a suite's tests notice, of those tried on them."""
