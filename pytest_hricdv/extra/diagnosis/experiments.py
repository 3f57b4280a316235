"""Experiments: reruns failing tests without their suspected causes.

`diagnose` makes one `Experiments`, whose `groups` runs the experiments and returns the groups of failures. A test is
first rerun unchanged, outside its test function. If it passes there, its failure depends on a fixture, and the test is
no evidence. If it then passes without the suspected cause, the cause is confirmed; if it still fails, refuted. After
each experiment, the failures are grouped again, and the next experiment is on the group with the least evidence, or the
largest of several. The budget counts runs, not time, so the same report leads to the same experiments.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

from pytest_hricdv.extra.diagnosis.failures import Failure
from pytest_hricdv.extra.diagnosis.grouping import Change, ExperimentEvidence, Group
from pytest_hricdv.extra.diagnosis.records import DiagnosisEnd, Experiment
from pytest_hricdv.extra.diagnosis.runs import Run, RunSummary
from pytest_hricdv.extra.diagnosis.variations import without
from pytest_hricdv.generate.concrete import ConcreteTest


def list_experiments(evidence: ExperimentEvidence) -> tuple[Experiment, ...]:
    """The evidence as records of a report."""
    confirmed = [(*key, change, True) for key, change in evidence.confirmed.items()]
    refuted = [(*key, change, False) for key, changes in evidence.refuted.items() for change in sorted(changes)]
    shown = tuple(
        Experiment(nodeid=nodeid, requirement=requirement, change=change, is_confirmed=is_confirmed)
        for nodeid, requirement, change, is_confirmed in sorted([*confirmed, *refuted])
    )
    pairs = [*((*pair, True) for pair in evidence.together), *((*pair, False) for pair in evidence.apart)]
    return shown + tuple(
        Experiment(nodeid=nodeid, requirement=passed, change="", is_confirmed=is_confirmed, other=other)
        for nodeid, passed, other, is_confirmed in sorted(pairs)
    )


def evidence_of(experiments: Iterable[Experiment]) -> ExperimentEvidence:
    """The evidence in the experiments of a report."""
    confirmed: dict[tuple[str, str], Change] = {}
    refuted: dict[tuple[str, str], set[Change]] = {}
    apart: set[tuple[str, str, str]] = set()
    together: set[tuple[str, str, str]] = set()
    for experiment in experiments:
        key = experiment.nodeid, experiment.requirement
        if experiment.other:
            (together if experiment.is_confirmed else apart).add((*key, experiment.other))
        elif experiment.is_confirmed:
            confirmed[key] = experiment.change
        else:
            refuted.setdefault(key, set()).add(experiment.change)
    return ExperimentEvidence(confirmed, refuted, apart=frozenset(apart), together=frozenset(together))


@dataclass
class Experiments:
    """Runs experiments until nothing is open, or the budget is spent.

    Args:
        grouping: makes groups of failures, given evidence.
        tests: node id -> the failing test.
        budget: maximum number of runs.
    """

    grouping: Callable[[ExperimentEvidence], tuple[Group, ...]]
    tests: Mapping[str, ConcreteTest]
    run: Run
    budget: int
    used: int = 0
    ended: DiagnosisEnd = "done"
    confirmed: dict[tuple[str, str], Change] = field(default_factory=dict)
    refuted: dict[tuple[str, str], set[Change]] = field(default_factory=dict)
    controls: dict[str, RunSummary | None] = field(default_factory=dict)
    """Node id -> the run of the unchanged test."""
    without: dict[tuple[str, Change], RunSummary | None] = field(default_factory=dict)
    """Node id and disturbance -> the run of the test without it."""
    runs: dict[str, list[RunSummary]] = field(default_factory=dict)
    """Node id -> all runs of the test and its variations."""
    switched: dict[tuple[str, str, str], list[tuple[str, int]]] = field(default_factory=dict)
    """First failure of a cause -> file and line of the decisions whose reversal makes its tests pass."""
    together: set[tuple[str, str, str]] = field(default_factory=set)
    """See `ExperimentEvidence`."""
    _tried: set[tuple[str, Change]] = field(default_factory=set)

    @property
    def evidence(self) -> ExperimentEvidence:
        """The evidence from the experiments."""
        apart = frozenset(self._apart())
        shown = ExperimentEvidence(self.confirmed, self.refuted, apart=apart, together=frozenset(self.together))
        return evidence_of(list_experiments(shown))

    def _apart(self) -> Iterator[tuple[str, str, str]]:
        """The test, and a passed and a failed requirement, of each run that fixes only some of the violations."""
        for nodeid, control in self.controls.items():
            violated = set() if control is None else {*control.violated}
            for result in self.runs.get(nodeid, ()):
                pairs = product(violated & {*result.checked}, violated & {*result.violated})
                yield from ((nodeid, passed, failed) for passed, failed in pairs)

    def groups(self, enough: float = math.inf) -> tuple[Group, ...]:
        """The groups, after experiments with all of their tests, or with `enough` of each."""
        if self.ended == "interrupted":
            return self.grouping(self.evidence)
        groups = self.grouping(replace(self.evidence, asks=True))
        self.ended = "done"
        try:
            while (wanted := self._next(groups)) is not None and self._count_tried(wanted[1]) < enough:
                if self.used + (1 if wanted[0] in self.controls else 2) > self.budget:
                    self.ended = "runs"
                    break
                self._try(*wanted)
                groups = self.grouping(replace(self.evidence, asks=True))
        except KeyboardInterrupt:
            self.ended = "interrupted"
        return self.grouping(self.evidence)

    def _next(self, groups: Sequence[Group]) -> tuple[str, Group] | None:
        """The test and the group of the next experiment: the largest of the groups with the fewest tests tried."""
        ranks = [(self._count_tried(group), number) for number, group in enumerate(groups) if self._open_tests(group)]
        if not ranks:
            return None
        group = groups[min(ranks)[1]]
        return min(self._open_tests(group), key=self.length), group

    def _open_tests(self, group: Group) -> list[str]:
        """The tests that have not been tried without the change of their group."""
        names = group.nodeids if group.change else ()
        return [name for name in names if name in self.tests and (name, group.change) not in self._tried]

    def _count_tried(self, group: Group) -> int:
        return sum((name, group.change) in self._tried for name in group.nodeids)

    def length(self, nodeid: str) -> tuple[int, str]:
        """Orders tests by their actions, the shortest first."""
        return len(self.tests[nodeid].actions), nodeid

    def _try(self, nodeid: str, group: Group) -> None:
        self._tried.add((nodeid, group.change))
        control = self.control(nodeid)
        violated = () if control is None else control.violated
        again = [failure for failure in _test_failures(group, nodeid) if failure.requirement in violated]
        result = self.ran(nodeid, without(self.tests[nodeid], group.change)) if again else None
        self.without[nodeid, group.change] = result
        if result is None:
            return
        for failure in again:
            key = nodeid, failure.requirement
            if failure.requirement in result.violated:
                self.refuted.setdefault(key, set()).add(group.change)
            else:
                self.confirmed[key] = group.change

    def control(self, nodeid: str) -> RunSummary | None:
        """The run of the unchanged test."""
        if nodeid not in self.controls:
            self.controls[nodeid] = self.ran(nodeid, self.tests[nodeid])
        return self.controls[nodeid]

    def ran(self, nodeid: str, test: ConcreteTest) -> RunSummary | None:
        """Run a test of the session or a variation of it; the run counts towards the budget."""
        self.used += 1
        result = self.run(test)
        if result is not None:
            self.runs.setdefault(nodeid, []).append(result)
        return result


def _test_failures(group: Group, nodeid: str) -> Iterator[Failure]:
    return (failure for failure in group.failures if failure.nodeid == nodeid)
