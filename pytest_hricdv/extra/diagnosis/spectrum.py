"""Spectrum-based fault localization: which statements failing tests execute, and passing ones do not.

`Subject` has the `Spectra` of a report's tests. `Spectra.suspects` ranks statements for `locations`, `Spectra.specific`
tells kinds of failures apart for `grouping`. The coefficient is Ochiai's (R. Abreu, P. Zoeteweij, A. van Gemund: On the
Accuracy of Spectrum-based Fault Localization, TAIC PART 2007).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

from pytest_hricdv.coverage.code_map import Bits, CodeMap

MAX_COMPARED = 3
"""Number of the most suspicious statements by which failures are compared: a bug is seldom larger than three."""


@dataclass(frozen=True)
class ExecutionCounts:
    """The numbers of tests that execute an element of the code.

    Args:
        failing: failing tests that execute the element.
        passing: passing tests that execute it.
        all_failing: all failing tests.
    """

    failing: int
    passing: int
    all_failing: int


def ochiai(counts: ExecutionCounts) -> float:
    """Ochiai's coefficient, from 0 to 1: 1 for what all failing tests execute and no passing one."""
    executing = counts.failing + counts.passing
    return counts.failing / math.sqrt(counts.all_failing * executing) if counts.failing else 0.0


@dataclass(frozen=True)
class Suspect:
    """A statement with its suspiciousness.

    Args:
        line: first line of the statement.
        score: the score of the statement, or of the most suspicious branch that leaves it.
        passing: how many passing tests execute it.
        own: score of the statement itself.
        branches: line to which a branch leaves it, below 0 for the end of the function, and its score.
    """

    file: str
    line: int
    score: float
    passing: int
    own: float = 0.0
    branches: tuple[tuple[int, float], ...] = ()


def rank(
    code: CodeMap, statements: Sequence[ExecutionCounts], branches: Sequence[ExecutionCounts]
) -> tuple[Suspect, ...]:
    """The statements that failing tests execute, the most suspicious first.

    A branch speaks for the statement that it leaves. Of equal ones, those come first that fewer passing tests execute,
    then those that come later in the text: what a wrong decision leads to stands below it.

    Args:
        code: the code under test.
        statements: counts in the order of their bits.
        branches: likewise.
    """
    return tuple(
        sorted(
            _suspects(code, statements, branches),
            key=lambda suspect: (-suspect.score, suspect.passing, suspect.file, -suspect.line),
        )
    )


def _suspects(
    code: CodeMap, statements: Sequence[ExecutionCounts], branches: Sequence[ExecutionCounts]
) -> Iterator[Suspect]:
    first_statement = first_branch = 0
    for file in code.files:
        leaving: dict[int, list[tuple[int, float]]] = {}
        for place, (line, to) in enumerate(file.branches, first_branch):
            leaving.setdefault(line, []).append((to, ochiai(branches[place])))
        for place, line in enumerate(file.statements, first_statement):
            counts = statements[place]
            if counts.failing:
                own, ways = ochiai(counts), tuple(leaving.get(line, ()))
                yield Suspect(file.name, line, max(own, *(score for _, score in ways), 0.0), counts.passing, own, ways)
        first_statement += len(file.statements)
        first_branch += len(file.branches)


def combine(suspects: Iterable[Suspect], near: Spectra, failing: Collection[str]) -> tuple[Suspect, ...]:
    """The suspects of all tests, with the geometric mean of their scores and those among variations of one test.

    What no variation executes, as what an import does, keeps its score.

    Args:
        suspects: the suspects of all tests.
        near: what the variations execute.
        failing: those that fail.
    """
    of_near = {(suspect.file, suspect.line): suspect for suspect in near.suspects(failing)}
    executed = {(suspect.file, suspect.line) for suspect in near.suspects([*near.bits])}
    combined = []
    for suspect in suspects:
        place = suspect.file, suspect.line
        if place not in executed:
            combined.append(suspect)
        elif (other := of_near.get(place)) is not None:
            scores = dict(other.branches)
            ways = tuple((to, math.sqrt(score * scores.get(to, 0.0))) for to, score in suspect.branches)
            own = math.sqrt(suspect.own * other.own)
            score = max(own, *(score for _, score in ways), 0.0)
            combined.append(replace(suspect, score=score, own=own, branches=ways))
    return tuple(sorted(combined, key=lambda suspect: -suspect.score))


@dataclass(frozen=True)
class ExecutionTable:
    """The tests that execute each element of the code, as bit sets, so that counting is one `and`.

    Args:
        bit_of: node id -> the bit of the test.
        statements: for each statement of the code map, in order, the tests that execute it.
        branches: the same of branches.
    """

    bit_of: Mapping[str, int]
    statements: tuple[int, ...]
    branches: tuple[int, ...]

    @classmethod
    def of(cls, code: CodeMap, bits: Mapping[str, Bits]) -> ExecutionTable:
        """The spectrum of what each test executes, by node ids."""
        bit_of = {name: 1 << place for place, name in enumerate(bits)}
        statements = ((measured.statements, bit_of[name]) for name, measured in bits.items())
        branches = ((measured.branches or 0, bit_of[name]) for name, measured in bits.items())
        return cls(bit_of, _transpose(statements, code.statements), _transpose(branches, code.branches))

    @property
    def all_tests(self) -> int:
        """The set of all tests that were measured."""
        return (1 << len(self.bit_of)) - 1

    def tests(self, names: Iterable[str]) -> int:
        """A set of measured tests."""
        return sum(self.bit_of[name] for name in {*names} if name in self.bit_of)

    def counts(self, elements: Collection[int], failing: int, passing: int) -> list[ExecutionCounts]:
        """Count the failing and passing tests that execute each of these elements."""
        all_failing = failing.bit_count()
        return [
            ExecutionCounts((tests & failing).bit_count(), (tests & passing).bit_count(), all_failing)
            for tests in elements
        ]


def _transpose(rows: Iterable[tuple[int, int]], size: int) -> tuple[int, ...]:
    """Built from the distinct sets of elements: thousands of tests execute the same few."""
    tests_with: dict[int, int] = {}
    for row, test in rows:
        tests_with[row] = tests_with.get(row, 0) | test
    columns = [0] * size
    for row, tests in tests_with.items():
        for place, bit in enumerate(reversed(bin(row)[2:])):
            if bit == "1":
                columns[place] |= tests
    return tuple(columns)


@dataclass(frozen=True)
class Spectra:
    """The spectra of all tests.

    Args:
        code: None if none was measured.
        bits: node id -> what the test executes; unmeasured tests are left out.
    """

    code: CodeMap | None = None
    bits: Mapping[str, Bits] = field(default_factory=dict)

    def suspects(self, failing: Collection[str], find_violators: Collection[str] = ()) -> tuple[Suspect, ...]:
        """The statements that these tests execute, the most suspicious first.

        Args:
            failing: node ids of the tests.
            find_violators: finds the tests with other failures, which are not passing tests.
        """
        if self.code is None:
            return ()
        table = self.table
        failed = table.tests(failing)
        passed = table.all_tests & ~failed & ~table.tests(find_violators)
        statements, branches = (
            table.counts(elements, failed, passed) for elements in (table.statements, table.branches)
        )
        return rank(self.code, statements, branches)

    def specific(self, failing: Collection[str], find_violators: Collection[str]) -> frozenset[tuple[str, int]]:
        """The first of the suspects: file and line of those that are more suspicious than what all tests execute.

        Args:
            failing: see `suspects`.
            find_violators: see `suspects`.
        """
        passing = len(self.bits.keys() - {*find_violators, *failing})
        anyway = ochiai(ExecutionCounts(len(failing), passing, len(failing)))
        first = self.suspects(sorted(failing), find_violators)[:MAX_COMPARED]
        return frozenset((suspect.file, suspect.line) for suspect in first if suspect.score > anyway)

    @cached_property
    def table(self) -> ExecutionTable:
        """The table of the tests that execute each element."""
        return ExecutionTable.of(self.code, self.bits) if self.code is not None else ExecutionTable({}, (), ())
