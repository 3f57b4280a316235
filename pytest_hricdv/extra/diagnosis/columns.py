"""Columns: of each element of the code, which tests execute it.

Coverage comes test by test. Grouping asks for hundreds of sets of tests how many of each execute an element: with the
tests that execute it as the bits of one number, that is one `and`.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass

from pytest_hricdv.coverage.code_map import Bits, CodeMap
from pytest_hricdv.extra.diagnosis.spectrum import Counts


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
