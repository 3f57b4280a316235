"""`PairSearch`: finds the deciding change of each cause and its shortest test, with the runs that experiments left.

`diagnose` calls its `decide` with the groups of failures. For each group, it shrinks a failing test (`shrunk`), and
`NeighborSearch` looks for the nearest passing run. `keep_run` writes the replay file of a test that was shrunk.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

from msgspec.structs import replace

from pytest_hricdv.execution.hri_case import HriCase
from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.experiments.shrink import shrink
from pytest_hricdv.extra.diagnosis.executed_lines import Showing
from pytest_hricdv.extra.diagnosis.experiments import Experiments
from pytest_hricdv.extra.diagnosis.grouping import Group
from pytest_hricdv.extra.diagnosis.minimal_pair import NeighborSearch, Tried
from pytest_hricdv.extra.diagnosis.records import Decision, Neighbour
from pytest_hricdv.extra.diagnosis.runs import Run, RunSummary, in_fork
from pytest_hricdv.extra.diagnosis.variations import Variation, without
from pytest_hricdv.generate.concrete import ConcreteTest, Concretization
from pytest_hricdv.results.replay import ReplayOrigin
from pytest_hricdv.session.replaying import TestRerunner, name_test


@dataclass(frozen=True)
class Minimal:
    """A test that was shrunk.

    Args:
        test: the shrunk test.
        ran: its run.
        requirement: the requirement that it violates, as the whole test does.
        runs: number of runs that shrinking took.
        is_done: whether nothing more can be taken away; otherwise the runs were used up.
    """

    test: ConcreteTest
    ran: RunSummary
    requirement: str
    runs: int
    is_done: bool


def shrunk(
    test: ConcreteTest, space: Concretization, control: RunSummary, requirement: str, run: Run, budget: int
) -> Minimal:
    """A failing test without the lines that it does not need to violate the requirement.

    Args:
        space: the ranges of its parameters.
        control: its run. If this violates the requirement outside of the condition of a known violation, so does the
            shrunk test.
        budget: maximum number of runs.

    Raises:
        KeyboardInterrupt: the user pressed Ctrl-C.
    """
    runs = {test.to_json(): control}
    is_outside = requirement in control.outside

    def fails(candidate: ConcreteTest) -> bool:
        result = run(candidate)
        if result is None or requirement not in (result.outside if is_outside else result.violated):
            return False
        runs[candidate.to_json()] = result
        return True

    outcome = shrink(test, space, fails, Budget(budget))
    if outcome.ended == "interrupted":
        raise KeyboardInterrupt
    return Minimal(outcome.test, runs[outcome.test.to_json()], requirement, outcome.runs, outcome.ended == "done")


def keep_run(rerunner: TestRerunner, case: HriCase, nodeid: str, minimal: Minimal) -> str | None:
    """Run a shrunk test once more and keep it as a replay file. Returns the file's name, None if there is none.

    Args:
        case: the test that was shrunk, with its node id.
    """
    origin = ReplayOrigin("shrunk", case.abstract.id, minimal.requirement, minimal.runs)

    def work() -> RunSummary | None:
        result = rerunner.run(name_test(minimal.test, f"{minimal.requirement}-shrunk"))
        return (
            None if result is None else RunSummary(violated=(), replay=rerunner.keep(case, result, nodeid, origin)[1])
        )

    made = in_fork(rerunner, work, RunSummary)
    return None if made is None else made.replay


MIN_TO_SHRINK = 16
"""With fewer runs for a cause, its shortest test is not shrunk. Chosen: half of them is for shrinking, and a test
of four actions takes some eight runs."""


@dataclass
class PairSearch:
    """The search for the deciding changes of causes.

    Args:
        experiments: the experiments that have been made; further runs are counted with theirs.
        spaces: node id -> the ranges of the test's parameters.
        neighbour_runner: runs a neighbour that passes once more, to be shown; this run is counted, too.
    """

    experiments: Experiments
    spaces: Mapping[str, Concretization]
    neighbour_runner: Showing = lambda test: None
    made: dict[tuple[str, str], Decision] = field(default_factory=dict)
    """Node id and requirement -> what decides."""
    minimal: dict[tuple[str, str], Minimal] = field(default_factory=dict)
    """Node id and requirement -> the shrunk test."""
    replays: dict[tuple[str, str], str | None] = field(default_factory=dict)
    """The same -> the replay file of this."""

    def of(self, group: Group) -> Decision | None:
        """The decision of a cause; None if none was tried."""
        keys = ((failure.nodeid, failure.requirement) for failure in group.failures)
        return next((self.made[key] for key in keys if key in self.made), None)

    def minimal_of(self, group: Group) -> dict[str, Minimal]:
        """Node id -> its shrunk test, for those that were shrunk for this cause."""
        made = ((failure.nodeid, self.minimal.get((failure.nodeid, failure.requirement))) for failure in group.failures)
        return {nodeid: minimal for nodeid, minimal in made if minimal is not None}

    def decide(self, groups: Sequence[Group]) -> None:
        """Look for what decides, of one cause after the other: each may use its share of the runs that are left."""
        if self.experiments.ended == "interrupted":
            return
        groups = [group for group in groups if not group.is_known]
        try:
            for number, group in enumerate(groups):
                left = self.experiments.budget - self.experiments.used
                self._decide(group, left // (len(groups) - number))
        except KeyboardInterrupt:
            self.experiments.ended = "interrupted"

    def _decide(self, group: Group, share: int) -> None:
        experiments = self.experiments
        nodeid = self.shortest(group)
        if nodeid is None or (share < 1 and nodeid not in experiments.controls):
            return
        is_new = nodeid not in experiments.controls
        control = experiments.control(nodeid)
        wanted = {failure.requirement for failure in group.failures if failure.nodeid == nodeid}
        if control is None or not wanted & set(control.violated):
            return
        test, space, left, before = experiments.tests[nodeid], self.spaces[nodeid], share - is_new, self._before(nodeid)
        ran = partial(experiments.ran, nodeid)
        if left >= MIN_TO_SHRINK:
            first = next(name for name in _in_order(group, nodeid) if name in control.violated)
            minimal = shrunk(test, space, control, first, ran, left // 2)
            left -= minimal.runs + 1  # one to keep it
            if minimal.test != test:
                self.minimal[nodeid, first] = minimal
                test, control, before = minimal.test, minimal.ran, iter(())
        to_show = 1 if left > 1 else 0
        deciding = NeighborSearch(test, space, control, wanted & set(control.violated), ran, left - to_show)
        decision = deciding.decision(before)
        if decision is not None and deciding.neighbour is not None and deciding.used < left:
            decision = replace(decision, neighbour=self._show(deciding.neighbour))
        if decision is not None:
            for requirement in wanted:
                self.made[nodeid, requirement] = decision

    def _show(self, neighbour: ConcreteTest) -> Neighbour | None:
        self.experiments.used += 1
        return self.neighbour_runner(neighbour)

    def shortest(self, group: Group) -> str | None:
        """The test to look at: the shortest that shows it, if possible one that experiments have confirmed."""
        experiments = self.experiments
        names = [name for name in group.nodeids if name in experiments.tests]
        confirmed = {name for name, _ in experiments.confirmed}
        lengths = {name: len(experiments.tests[name].actions) for name in names}
        return min(
            names,
            key=lambda name: (name not in group.telling, name not in confirmed, lengths[name], name),
            default=None,
        )

    def _before(self, nodeid: str) -> Iterator[Tried]:
        """The runs of this test without a disturbance."""
        for (name, change), result in self.experiments.without.items():
            if name == nodeid and result is not None:
                test = without(self.experiments.tests[nodeid], change)
                yield Variation("disturbance", f"without the disturbance {change}", test), result


def _in_order(group: Group, nodeid: str) -> Iterator[str]:
    """The requirements that a test fails for a cause, in the order of time."""
    return (failure.requirement for failure in group.failures if failure.nodeid == nodeid)
