"""Experiments: a failing test is run again without what it is thought to fail for.

First it runs as it was: what does not fail then, outside of its test function, fails for what a fixture does, and shows
nothing. What passes without it has failed for that; what fails all the same has another cause. So hypotheses are
confirmed or refuted, the groups are made anew, and the next experiment is about the largest group of which least is
known. Experiments are counted, not timed, so the same report leads to the same ones.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from pytest_hricdv.disturbance import PREFIX
from pytest_hricdv.extra.diagnosis.failures import Failure
from pytest_hricdv.extra.diagnosis.grouping import Change, Evidence, Group
from pytest_hricdv.extra.diagnosis.records import DiagnosisEnd
from pytest_hricdv.generate.concrete import ConcreteTest

Run = Callable[[ConcreteTest], frozenset[str] | None]
"""Runs a test: the requirements that it violates, `failures.FAULT` among them; None where the run came to no end."""


@dataclass
class Experiments:
    """Runs experiments until nothing is open, or the budget is spent.

    Args:
        grouping: makes groups, given evidence.
        tests: node id -> the failing test.
        run: runs a test.
        budget: at most so many runs.
    """

    grouping: Callable[[Evidence], tuple[Group, ...]]
    tests: Mapping[str, ConcreteTest]
    run: Run
    budget: int
    used: int = 0
    ended: DiagnosisEnd = "done"
    confirmed: dict[tuple[str, str], Change] = field(default_factory=dict)
    refuted: dict[tuple[str, str], set[Change]] = field(default_factory=dict)
    _tried: set[tuple[str, Change]] = field(default_factory=set)
    _controls: dict[str, frozenset[str]] = field(default_factory=dict)
    """Node id -> what the test violates as it was."""

    @property
    def evidence(self) -> Evidence:
        """What they have shown."""
        return Evidence(self.confirmed, self.refuted)

    def groups(self) -> tuple[Group, ...]:
        """The groups, after all experiments."""
        groups = self.grouping(self.evidence)
        try:
            while (wanted := self._next(groups)) is not None:
                if self.used + (1 if wanted[0] in self._controls else 2) > self.budget:
                    self.ended = "runs"
                    break
                self._try(*wanted)
                groups = self.grouping(self.evidence)
        except KeyboardInterrupt:
            self.ended = "interrupted"
        return groups

    def _next(self, groups: Sequence[Group]) -> tuple[str, Group] | None:
        """The test and the group of the next experiment: the group with fewest tests tried, the largest first."""
        open_groups = [(self._confirmed(group), number) for number, group in enumerate(groups) if self._open(group)]
        if not open_groups:
            return None
        group = groups[min(open_groups)[1]]
        return min(self._open(group), key=self._length), group

    def _open(self, group: Group) -> list[str]:
        """The tests that were not tried without the change of their group."""
        names = group.nodeids if group.change else ()
        return [name for name in names if name in self.tests and (name, group.change) not in self._tried]

    def _confirmed(self, group: Group) -> int:
        return sum((name, group.change) in self._tried for name in group.nodeids)

    def _length(self, nodeid: str) -> tuple[int, str]:
        return len(self.tests[nodeid].actions), nodeid

    def _try(self, nodeid: str, group: Group) -> None:
        self._tried.add((nodeid, group.change))
        if nodeid not in self._controls:
            self._controls[nodeid] = self._violated(self.tests[nodeid]) or frozenset()
        again = [failure for failure in _of_test(group, nodeid) if failure.requirement in self._controls[nodeid]]
        violated = self._violated(without(self.tests[nodeid], group.change)) if again else None
        if violated is None:
            return
        for failure in again:
            key = nodeid, failure.requirement
            if failure.requirement in violated:
                self.refuted.setdefault(key, set()).add(group.change)
            else:
                self.confirmed[key] = group.change

    def _violated(self, test: ConcreteTest) -> frozenset[str] | None:
        self.used += 1
        return self.run(test)


def _of_test(group: Group, nodeid: str) -> Iterator[Failure]:
    return (failure for failure in group.failures if failure.nodeid == nodeid)


def without(test: ConcreteTest, change: Change) -> ConcreteTest:
    """The test without a disturbance, wherever it comes."""
    return replace(test, actions=tuple(action for action in test.actions if action.command != PREFIX + change))
