"""Spectrum-based fault localization: which statements failing tests execute, and passing ones do not.

The coefficients are Ochiai (R. Abreu, P. Zoeteweij, A. van Gemund: On the Accuracy of Spectrum-based Fault
Localization, TAIC PART 2007) and DStar with the exponent 2 (W. Wong, V. Debroy, R. Gao, Y. Li: The DStar Method for
Effective Software Fault Localization, IEEE Transactions on Reliability 63(1), 2014).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from pytest_hricdv.coverage.code_map import Bits, CodeMap


@dataclass(frozen=True)
class Counts:
    """How many tests execute an element of the code, and how many do not.

    Args:
        failing: tests that fail and execute it.
        passing: tests that pass and execute it.
        all_failing: tests that fail.
    """

    failing: int
    passing: int
    all_failing: int


def ochiai(counts: Counts) -> float:
    """From 0 to 1: 1 for what all failing tests execute and no passing one."""
    executing = counts.failing + counts.passing
    return counts.failing / math.sqrt(counts.all_failing * executing) if counts.failing else 0.0


def dstar(counts: Counts) -> float:
    """From 0 on, infinite for what all failing tests execute and no passing one."""
    others = counts.passing + counts.all_failing - counts.failing
    if not counts.failing:
        return 0.0
    return math.inf if not others else counts.failing**2 / others


Coefficient = Callable[[Counts], float]


@dataclass(frozen=True)
class Suspect:
    """A statement with its suspiciousness.

    Args:
        file: name, as in the report.
        line: first line of the statement.
        score: of the statement, or of the most suspicious branch that leaves it.
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


def suspects(
    code: CodeMap, failing: Iterable[Bits], passing: Iterable[Bits], coefficient: Coefficient = ochiai
) -> tuple[Suspect, ...]:
    """The statements that failing tests execute, the most suspicious first.

    A branch speaks for the statement that it leaves. Of equal ones, those come first that fewer passing tests execute,
    then those that come later in the text: what a wrong decision leads to stands below it.

    Args:
        code: with as many bits as the tests have.
        failing: what each failing test executes.
        passing: the same of tests that do not fail.
        coefficient: the measure of suspiciousness.
    """
    failing, passing = tuple(failing), tuple(passing)
    statements = _counts(
        Counter(test.statements for test in failing), Counter(test.statements for test in passing), code.statements
    )
    branches = _counts(
        Counter(test.branches or 0 for test in failing), Counter(test.branches or 0 for test in passing), code.branches
    )
    return ranked(code, statements, branches, coefficient)


def ranked(
    code: CodeMap, statements: Sequence[Counts], branches: Sequence[Counts], coefficient: Coefficient = ochiai
) -> tuple[Suspect, ...]:
    """As `suspects`, of tests that have been counted already: in the order of their bits."""
    scored = _scored(code, statements, branches, coefficient)
    return tuple(sorted(scored, key=lambda suspect: (-suspect.score, suspect.passing, suspect.file, -suspect.line)))


def statement_counts(code: CodeMap, failing: Iterable[Bits], passing: Iterable[Bits]) -> list[Counts]:
    """Of each statement, in the order of its bits."""
    return _counts(
        Counter(test.statements for test in failing), Counter(test.statements for test in passing), code.statements
    )


def _counts(failing: Counter[int], passing: Counter[int], size: int) -> list[Counts]:
    """Bit by bit. Thousands of tests execute the same few sets of statements, so each set is looked at once."""
    all_failing = failing.total()
    return [Counts(_executing(failing, place), _executing(passing, place), all_failing) for place in range(size)]


def _executing(sets: Counter[int], place: int) -> int:
    return sum(count for bits, count in sets.items() if bits >> place & 1)


def _scored(
    code: CodeMap, statements: Sequence[Counts], branches: Sequence[Counts], coefficient: Coefficient
) -> Iterator[Suspect]:
    first_statement = first_branch = 0
    for file in code.files:
        leaving: dict[int, list[tuple[int, float]]] = {}
        for place, (line, to) in enumerate(file.branches, first_branch):
            leaving.setdefault(line, []).append((to, coefficient(branches[place])))
        for place, line in enumerate(file.statements, first_statement):
            counts = statements[place]
            if counts.failing:
                own, ways = coefficient(counts), tuple(leaving.get(line, ()))
                yield Suspect(file.name, line, max(own, *(score for _, score in ways), 0.0), counts.passing, own, ways)
        first_statement += len(file.statements)
        first_branch += len(file.branches)


@dataclass(frozen=True)
class Columns:
    """Which tests execute what.

    Args:
        bit_of: node id -> the bit of the test.
        statements: of each statement of the code map, in its order, the tests that execute it.
        branches: the same of branches.
    """

    bit_of: Mapping[str, int]
    statements: tuple[int, ...]
    branches: tuple[int, ...]

    @classmethod
    def of(cls, code: CodeMap, bits: Mapping[str, Bits]) -> Columns:
        """Of what each test executes, by node ids."""
        bit_of = {name: 1 << place for place, name in enumerate(bits)}
        statements = ((measured.statements, bit_of[name]) for name, measured in bits.items())
        branches = ((measured.branches or 0, bit_of[name]) for name, measured in bits.items())
        return cls(bit_of, _transposed(statements, code.statements), _transposed(branches, code.branches))

    @property
    def all_tests(self) -> int:
        """The set of all tests that were measured."""
        return (1 << len(self.bit_of)) - 1

    def tests(self, names: Iterable[str]) -> int:
        """A set of tests; those that were not measured are not in it."""
        return sum(self.bit_of[name] for name in {*names} if name in self.bit_of)

    def counts(self, elements: Collection[int], failing: int, passing: int) -> list[Counts]:
        """How many of the failing and passing tests execute each of these elements."""
        all_failing = failing.bit_count()
        return [Counts((tests & failing).bit_count(), (tests & passing).bit_count(), all_failing) for tests in elements]


def _transposed(rows: Iterable[tuple[int, int]], size: int) -> tuple[int, ...]:
    """Thousands of tests execute the same few sets of elements, so each set is looked at once."""
    tests_with: dict[int, int] = {}
    for row, test in rows:
        tests_with[row] = tests_with.get(row, 0) | test
    columns = [0] * size
    for row, tests in tests_with.items():
        for place, bit in enumerate(reversed(bin(row)[2:])):
            if bit == "1":
                columns[place] |= tests
    return tuple(columns)
