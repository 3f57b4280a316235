"""The search for schedules under which a test fails that passes under the usual one.

One run of a test notes which node executes which statement when. Where two nodes read and write the same data, the
first is held up until the other one has run, which reverses their order (see `pairs`). Pairs that were not reversed yet
are tried first. Where the other one comes too late for that, a parameter of the test is moved so that it comes in time.
A run has one to three decisions: most races need one (S. Burckhardt, P. Kothari, M. Musuvathi, S. Nagarakatte: A
Randomized Scheduler with Probabilistic Guarantees of Finding Bugs, ASPLOS 2010).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import groupby, islice
from random import Random

import msgspec

from pytest_hricdv._base.record import Count, Names, NotNegative, PlainRecord
from pytest_hricdv.execution.forked import ForkError, InFork, fork
from pytest_hricdv.extra.schedules.execution import note_runs
from pytest_hricdv.extra.schedules.pairs import DataConflict, conflicts, thin
from pytest_hricdv.extra.schedules.scheduler import Scheduler, accesses
from pytest_hricdv.generate.concrete import ConcreteTest, Concretization
from pytest_hricdv.generate.rng import make_rng
from pytest_hricdv.generate.sampler import Sampler
from pytest_hricdv.generate.schedule import ScheduleDecision
from pytest_hricdv.session.replaying import TestRerunner, name_test

MOST_DECISIONS = 3
"""In one run."""

ONE = 0.6
"""The share of runs with one decision only."""

CAUSED = 0.75
"""The share of moves of the action that the second of a pair came after; the others move any action."""

HOLDS = 3
"""So many places to hold a thread up are tried for a pair: see `ScheduleSearch._reverse`."""

AT_RANDOM = 0.25
"""The share of runs whose decisions are drawn without looking at pairs: what static names miss may be there."""

MAX_SLICES = 20_000
"""So many slices of a run are noted."""

PlacePair = tuple[str, str]
"""The place of the statement that came first, and of the one that came next to the same data."""


class HeldNode(PlainRecord, frozen=True, kw_only=True):
    """What a decision did: the place, the node that waited there, when and for how long (s), and what came between."""

    place: str
    node: str
    time_s: NotNegative
    for_s: NotNegative
    between: tuple[tuple[str, str], ...] = ()


class ScheduleRun(PlainRecord, frozen=True, kw_only=True):
    """A run with a schedule, or one without that was noted.

    Args:
        violated: requirements.
        faults: what else was wrong with it, a sentence each.
        threads: how many threads of the code, or tasks of asyncio, executed anything.
        conflicts: some of each pair.
        executed: place -> how often.
        ready: of each choice between nodes, how many were ready.
        actions: when they began (s), and their numbers from 1.
        held: what decisions did.
        slices: which thread executed something, one after the other, and how many statements at a time; the first
            ones.
        record: SHA-256 of the record.
    """

    violated: Names = ()
    faults: Names = ()
    threads: Count = 0
    conflicts: tuple[DataConflict, ...] = ()
    executed: Mapping[str, Count] = {}
    ready: tuple[Count, ...] = ()
    actions: tuple[tuple[NotNegative, Count], ...] = ()
    held: tuple[HeldNode, ...] = ()
    slices: tuple[tuple[Count, Count], ...] = ()
    record: str = ""

    @property
    def fails(self) -> frozenset[str]:
        """Requirements, and an empty text for a fault."""
        return frozenset(self.violated) | ({""} if self.faults else set())

    @property
    def involves(self) -> frozenset[str]:
        """Places where nodes were held up, and those that came in between."""
        places = [held.place for held in self.held] + [place for held in self.held for place, _ in held.between]
        return frozenset(place.rstrip("=") for place in places)


RunTest = Callable[[ConcreteTest], ScheduleRun | None]
"""Runs a test; None where the run came to no end."""


def runner(rerunner: TestRerunner) -> RunTest:
    """Runs tests in forks, so that whatever a schedule leads to ends with its run."""

    def run(test: ConcreteTest) -> ScheduleRun | None:
        process = fork()
        if isinstance(process, InFork):
            message = b"null"
            with suppress(BaseException):  # whatever it is: what stands above is for the process that was forked
                message = msgspec.json.encode(_run(rerunner, test))
            process.send_and_end(message)
        try:
            with rerunner.let_through():
                return msgspec.json.decode(process.message(), type=ScheduleRun | None)
        except ForkError:
            return None
        finally:
            process.close()

    return run


def _run(rerunner: TestRerunner, test: ConcreteTest) -> ScheduleRun | None:
    noted: list[Scheduler] = []
    note_runs(noted)
    result = rerunner.run(name_test(test, "schedule"))
    if result is None or not noted:
        return None
    violated = [
        verdict.requirement
        for verdict in result.verdicts
        if verdict.verdict == "Failed" and rerunner.is_violated(verdict.requirement, verdict)
    ]
    return msgspec.structs.replace(
        _summary(noted[0]),
        violated=tuple(violated),
        faults=result.errors,
        actions=tuple(zip(result.action_times_s, result.begun, strict=True)),
        record=result.record.sha256,
    )


def _summary(scheduler: Scheduler) -> ScheduleRun:
    places = scheduler.points.places
    return ScheduleRun(
        threads=len({step.thread for step in scheduler.steps}),
        conflicts=thin(conflicts(scheduler.steps, places, accesses(scheduler.points))),
        executed=dict(sorted(Counter(places[step.point] for step in scheduler.steps).items())),
        ready=tuple(choice.ready for choice in scheduler.choices),
        held=tuple(
            HeldNode(
                place=held.decision.place,
                node=held.node,
                time_s=round(held.time_s, 6),
                for_s=round(held.for_s, 6),
                between=held.meanwhile,
            )
            for held in scheduler.held_up
        ),
        slices=tuple(
            (thread, sum(1 for _ in steps))
            for thread, steps in islice(groupby(step.thread for step in scheduler.steps), MAX_SLICES)
        ),
    )


@dataclass(frozen=True)
class ScheduleCandidate:
    """A test of the session that passes, the ranges of its parameters, and its usual run."""

    nodeid: str
    test: ConcreteTest
    space: Concretization
    usual: ScheduleRun


@dataclass
class ScheduleSearch:
    """Draws schedules for tests, and keeps which pairs were tried.

    Args:
        run: runs tests.
        slowest_s: for so long a node is held up at most (s).
        seed: of the session.
    """

    run: RunTest
    slowest_s: float
    seed: int
    seen: set[PlacePair] = field(default_factory=set)
    """Pairs in the order in which some run executed them."""
    near: set[PlacePair] = field(default_factory=set)
    """Those that some run executed so fast that a hold reverses them."""
    tried: Counter[PlacePair] = field(default_factory=Counter)
    """Pairs whose first node was held up."""
    runs: int = 0
    found_later: list[tuple[ScheduleCandidate, ConcreteTest, DataConflict]] = field(default_factory=list)
    """Pairs that only runs with a schedule have, with the test that has it."""

    def note(
        self, run: ScheduleRun, candidate: ScheduleCandidate | None = None, test: ConcreteTest | None = None
    ) -> None:
        """Pairs that a run executed; with a schedule, those that are new or nearer lead to further decisions.

        Args:
            run: of a test.
            candidate: that the test was made of, if it has a schedule.
            test: with this schedule.
        """
        if candidate is not None and test is not None and len(test.schedule) < MOST_DECISIONS:
            later = {
                conflict.pair: conflict
                for conflict in run.conflicts
                if conflict.pair not in (self.near if self._is_near(conflict) else self.seen)
            }
            self.found_later += [(candidate, test, conflict) for conflict in later.values() for _ in range(HOLDS)]
        self.seen.update(conflict.pair for conflict in run.conflicts)
        self.near.update(conflict.pair for conflict in run.conflicts if self._is_near(conflict))

    def open_pairs(self) -> list[PlacePair]:
        """Pairs that came in one order only."""
        return sorted(pair for pair in self.seen if (pair[1], pair[0]) not in self.seen)

    def draw(self, candidates: Sequence[ScheduleCandidate]) -> Iterator[tuple[ScheduleCandidate, ConcreteTest]]:
        """Tests with schedules, without end; empty where no candidate has anything to order."""
        able = [candidate for candidate in candidates if candidate.usual.threads > 1 or candidate.usual.ready]
        number = 0
        while able:
            rng = make_rng("schedules", self.seed, number)
            number += 1
            made = None
            if rng.random() >= AT_RANDOM:
                made = (self._further() if number % 2 else None) or self._pair(rng, able)
            yield made or self._at_random(rng, able)

    def _pair(
        self, rng: Random, candidates: Sequence[ScheduleCandidate]
    ) -> tuple[ScheduleCandidate, ConcreteTest] | None:
        """The pair that was tried least, in one of the tests that have it."""
        found = [
            (self.tried[conflict.pair], self._needs_move(conflict), place, conflict)
            for place, candidate in enumerate(candidates)
            for conflict in candidate.usual.conflicts
        ]
        if not found:
            return None
        least = min(entry[:2] for entry in found)
        _, needs_move, place, conflict = rng.choice([entry for entry in found if entry[:2] == least])
        candidate = candidates[place]
        test: ConcreteTest | None = candidate.test
        if needs_move:
            test = self._move(rng, candidate, conflict)
        decisions = self._reverse(conflict)
        if test is None:
            return None
        if not decisions or rng.random() >= ONE:
            decisions += self._more(rng, candidate, rng.randint(1, MOST_DECISIONS - 1))
        return candidate, replace(test, schedule=_sort_decisions(decisions))

    def _further(self) -> tuple[ScheduleCandidate, ConcreteTest] | None:
        """A schedule with one more decision, about a pair that came only with it; None where none is left."""
        if not self.found_later:
            return None
        candidate, test, conflict = self.found_later.pop(0)
        return candidate, replace(test, schedule=_sort_decisions([*test.schedule, *self._reverse(conflict)]))

    def _reverse(self, conflict: DataConflict) -> list[ScheduleDecision]:
        """What lets the second one come before the first one; at the next times right after it, or earlier still."""
        turn = self.tried[conflict.pair]
        self.tried[conflict.pair] += 1
        first = conflict.first, conflict.number
        holds = [conflict.awaited] if conflict.is_in_one_node else [first, conflict.next, conflict.previous]
        held = holds[turn % len(holds)]
        return [] if held is None else [ScheduleDecision("hold", *held, self.slowest_s)]

    def _is_near(self, conflict: DataConflict) -> bool:
        return conflict.gap_s <= self.slowest_s

    def _needs_move(self, conflict: DataConflict) -> bool:
        """Whether the second one cannot come in between as the test is."""
        return conflict.is_in_one_node or not self._is_near(conflict)

    def _more(self, rng: Random, candidate: ScheduleCandidate, count: int) -> list[ScheduleDecision]:
        usual = candidate.usual
        if not usual.executed:
            return []
        near = [conflict for conflict in usual.conflicts if self._is_near(conflict)]
        made = []
        for _ in range(count):
            if usual.ready and rng.random() < 0.3:
                number = rng.randrange(len(usual.ready))
                made.append(ScheduleDecision("order", "", number + 1, rng.randrange(1, usual.ready[number])))
            elif near and rng.random() < 0.5:
                conflict = rng.choice(near)
                made.append(ScheduleDecision("hold", conflict.first, conflict.number, self.slowest_s))
            else:
                place = rng.choice([*usual.executed])
                made.append(ScheduleDecision("hold", place, rng.randint(1, usual.executed[place]), self.slowest_s))
        return made

    def _at_random(
        self, rng: Random, candidates: Sequence[ScheduleCandidate]
    ) -> tuple[ScheduleCandidate, ConcreteTest]:
        candidate = rng.choice([*candidates])
        decisions = self._more(rng, candidate, rng.randint(1, MOST_DECISIONS))
        return candidate, replace(candidate.test, schedule=_sort_decisions(decisions))

    def _move(self, rng: Random, candidate: ScheduleCandidate, conflict: DataConflict) -> ConcreteTest | None:
        """The test with one parameter changed so that the second statement may come in time; None where none can be."""
        change_s = conflict.gap_s - rng.uniform(0.0, min(self.slowest_s, conflict.gap_s))
        test, commands = candidate.test, candidate.space.commands
        options = [
            (place, name, changed)
            for place, action in enumerate(test.actions)
            for name, value in action.parameters.items()
            for changed in (value - change_s, value + change_s)
            if name.endswith("_s") and _may_be(commands.get(action.command, {}).get(name), changed)
        ]
        if not options:
            return None
        last = max((number - 1 for time_s, number in candidate.usual.actions if time_s <= conflict.second_s), default=0)
        caused = [entry for entry in options if entry[0] == last and entry[2] < test.actions[last].parameters[entry[1]]]
        place, name, changed = rng.choice(caused if caused and rng.random() < CAUSED else options)
        action = test.actions[place]
        action = replace(action, parameters={**action.parameters, name: changed})
        return replace(test, actions=(*test.actions[:place], action, *test.actions[place + 1 :]))


def _may_be(sampler: Sampler | None, value: float) -> bool:
    return sampler is not None and sampler.contains(value)


def _sort_decisions(decisions: Sequence[ScheduleDecision]) -> tuple[ScheduleDecision, ...]:
    return tuple(sorted(dict.fromkeys(decisions), key=lambda entry: (entry.kind, entry.place, entry.number)))
