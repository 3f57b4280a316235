"""Hints: repairs of suspicious statements that turn failing tests into passing ones, and nothing else.

A repair runs first with the shortest failing test of a cause. What mends this runs with others that fail for the cause,
and with some that pass and execute the statement. What mends all of the former and changes none of the latter is the
strongest evidence that there is where the fault is (S. Moon, Y. Kim, M. Kim, S. Yoo: Ask the Mutants: Mutating Faulty
Programs for Fault Localization, ICST 2014).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace

from pytest_hricdv.extra.diagnosis.failures import FAULT
from pytest_hricdv.extra.diagnosis.parting import share_kept
from pytest_hricdv.extra.diagnosis.repairs import Repair
from pytest_hricdv.extra.diagnosis.runs import Ran, RunChanged
from pytest_hricdv.generate.concrete import ConcreteTest

FURTHER = 3
"""So many further failing tests, and so many passing ones, a repair has to stand. Chosen: most that mend one test by
chance, as by doing nothing at all, fail another one."""

MOST_HINTS = 2
"""So many hints are looked for."""

LEAST_KEPT = 0.5
"""Of what happened before the violation, a repair has to leave so much as it was: a robot that does nothing at all does
no harm either, but this is not what is wrong. Chosen over 27 faults in three testbenches: of 17 repairs at the fault
that mend a test, 16 leave 0.8 or more; of 36 elsewhere, 26 leave nothing."""

ENOUGH_KEPT = 0.9
"""No better hint is looked for than those that leave so much as it was (chosen)."""


@dataclass(frozen=True)
class FailingTest:
    """A test that fails for a cause: the requirements that are to pass, all that it violates, its node id, its run."""

    test: ConcreteTest
    wanted: Collection[str]
    violated: Collection[str]
    nodeid: str = ""
    ran: Ran | None = None

    def kept(self, repaired: Ran) -> float:
        """The share of what happened before it failed that happens with a repair, too; 1 where nobody looked."""
        if self.ran is None:
            return 1.0
        times_s = [self.ran.times_s[name] for name in self.wanted if name in self.ran.times_s]
        return share_kept(self.ran, repaired, min(times_s, default=math.inf))


@dataclass(frozen=True)
class PassingTest:
    """A test that does not fail for a cause: the requirements that it checks and passes, and those that it violates."""

    test: ConcreteTest
    checked: Collection[str]
    violated: Collection[str]


@dataclass(frozen=True)
class Hint:
    """A repair, with how many failing tests pass with it, and how many others are as they were.

    Args:
        repair: the change.
        mended: failing tests that pass.
        unchanged: others.
        kept: share of what happened before the violation that happens with it, too.
    """

    repair: Repair
    mended: int
    unchanged: int
    kept: float = 1.0


@dataclass
class Repairing:
    """Looks for repairs, within a budget of runs.

    Args:
        run: runs a test with a repair.
        budget: at most so many runs.
    """

    run: RunChanged
    budget: int
    used: int = field(default=0, init=False)

    def hints(
        self,
        repairs: Iterable[Repair],
        failing: Sequence[FailingTest],
        passing: Callable[[Repair], Sequence[PassingTest]],
    ) -> list[Hint]:
        """The repairs that stand all tests, those first that change least; one of each statement.

        Args:
            repairs: to be tried, in this order.
            failing: tests of the cause, the shortest first.
            passing: of a repair, the tests that execute its statement, in the order in which they are tried.
        """
        hints: dict[tuple[str, int], Hint] = {}
        for repair in repairs:
            before = hints.get((repair.file, repair.line))
            if self.used >= self.budget or sum(hint.kept >= ENOUGH_KEPT for hint in hints.values()) >= MOST_HINTS:
                break
            if before is not None and before.kept >= ENOUGH_KEPT:
                continue
            ran = self._mending(repair, failing[0])
            kept = 0.0 if ran is None else failing[0].kept(ran)
            if ran is None or kept < LEAST_KEPT or (before is not None and kept <= before.kept):
                continue
            hint = self._stands(repair, failing[1 : 1 + FURTHER], passing(repair)[:FURTHER])
            if hint is not None:
                hints[repair.file, repair.line] = replace(hint, kept=kept)
        return sorted(hints.values(), key=lambda hint: -hint.kept)[:MOST_HINTS]

    def mended(self, repair: Repair, failing: Sequence[FailingTest]) -> Sequence[FailingTest]:
        """The first tests of another cause, if a repair mends all of them; else none, as where no run is left."""
        tried = failing[: min(1 + FURTHER, self.budget - self.used)]
        return tried if tried and all(self._mends(repair, test) for test in tried) else ()

    def _stands(self, repair: Repair, failing: Sequence[FailingTest], passing: Sequence[PassingTest]) -> Hint | None:
        mended, unchanged = 1, 0
        for number in range(max(len(failing), len(passing))):
            for other in passing[number : number + 1] if self.used < self.budget else ():
                if not self._leaves(repair, other):
                    return None
                unchanged += 1
            for test in failing[number : number + 1] if self.used < self.budget else ():
                if not self._mends(repair, test):
                    return None
                mended += 1
        return Hint(repair, mended, unchanged)

    def _mends(self, repair: Repair, failing: FailingTest) -> bool:
        return self._mending(repair, failing) is not None

    def _mending(self, repair: Repair, failing: FailingTest) -> Ran | None:
        """The run of a failing test with a repair, if it passes."""
        ran = self._ran(repair, failing.test)
        if ran is None:
            return None
        violated, checked = {*ran.violated}, {*ran.checked, FAULT}
        passes = violated <= {*failing.violated} - {*failing.wanted} and checked >= {*failing.wanted}
        return ran if passes else None

    def _leaves(self, repair: Repair, passing: PassingTest) -> bool:
        ran = self._ran(repair, passing.test)
        return (
            ran is not None
            and {*ran.violated} <= {*passing.violated}
            and {*ran.checked, *ran.violated} >= {*passing.checked}
        )

    def _ran(self, repair: Repair, test: ConcreteTest) -> Ran | None:
        self.used += 1
        return self.run(repair, test)
