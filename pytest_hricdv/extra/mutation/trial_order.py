"""The order in which tests are run with a mutant: nearest first, then those that add most to what was tried."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from pytest_hricdv.coverage.closure import MeasuredTest, minimal_suite


@dataclass(frozen=True)
class Candidate:
    """A test: the statements that it executes, all points that it covers (bit sets), and its simulated time (s)."""

    id: str
    suite: str
    statements: int
    points: int
    sim_s: float


class TrialOrder:
    """Which tests a mutant is tried on.

    Args:
        tests: of all suites.
        most: so many tests of each suite at most; None: all that execute the mutant's statement.
    """

    def __init__(self, tests: Sequence[Candidate], most: int | None) -> None:
        self._tests = tests
        self._most = most
        self._orders: dict[int, tuple[str, ...]] = {}

    def executing(self, statement: int) -> dict[str, int]:
        """Suite -> how many of its tests execute a statement, given by its number."""
        return dict(Counter(test.suite for test in self._tests if test.statements >> statement & 1))

    def tests(self, statement: int) -> tuple[str, ...]:
        """The ids of the tests to try, in order, suite after suite."""
        if statement not in self._orders:
            executing = [test for test in self._tests if test.statements >> statement & 1]
            order = []
            for suite in dict.fromkeys(test.suite for test in executing):
                order += _ordered([test for test in executing if test.suite == suite])[: self._most]
            self._orders[statement] = tuple(order)
        return self._orders[statement]


def _ordered(tests: Sequence[Candidate]) -> list[str]:
    """First the test that does least beside, so that a fault that any test notices costs one short run; then those that
    together cover all that these tests cover, the most per second first, because a test like the one before notices
    what that one noticed; then the rest, the shortest first.
    """
    shortest = sorted(tests, key=lambda test: (test.statements.bit_count(), test.sim_s, test.id))
    varied = minimal_suite([MeasuredTest(test.id, test.points, test.sim_s) for test in shortest])
    names = [shortest[0].id, *(step.name for step in varied), *(test.id for test in shortest)]
    return list(dict.fromkeys(names))
