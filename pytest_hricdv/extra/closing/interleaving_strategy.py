"""The strategy `interleaving`: tests of several actors, with turns that make certain actions meet in a certain order.

Two actions of two actors meet if none of theirs begins between them. An open bin that names what two actors do, and
perhaps who is first, is aimed at with tests in which these can meet. Where there is none, actions are made to meet in
the order in which they have met least often: what only another interleaving reaches is reached by one that was not
tried (as sequence covering arrays do: D. R. Kuhn, J. M. Higdon, J. F. Lawrence, R. N. Kacker, Y. Lei: Combinatorial
Methods for Event Sequence Testing, ICST Workshops 2012).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import combinations, pairwise, permutations
from random import Random
from typing import NamedTuple

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.pool import Pool
from pytest_hricdv.extra.closing.strategy import Archive, Proposal
from pytest_hricdv.generate.abstract import AbstractDraft
from pytest_hricdv.generate.actors import TURN, TURN_WAIT_S, After, act_of, actor_of, actors_of
from pytest_hricdv.generate.chosen_values import RUN
from pytest_hricdv.generate.rng import pick, pick_weighted
from pytest_hricdv.generate.sampler import Sampler

CANDIDATES = 24
"""Tests among which one with the rarest encounter is taken: enough for the few tests of a model with two actors. Each
costs a run of the model."""

MAX_TESTS = 512
"""Tests, evenly spread over the pool, in which possible encounters are looked up: some seconds of runs of the model."""


class Encounter(NamedTuple):
    """Two lines of two actors: the first one begins, then the other, and no line of theirs in between."""

    first: str
    then: str


class Place(NamedTuple):
    """A meeting in a test: the numbers of both actions, from 1."""

    first: int
    then: int


class Order:
    """The order of the actions of a test: its lanes, and their causes.

    Args:
        lines: of the test.
        after: see `pytest_hricdv.generate.actors`.
    """

    def __init__(self, lines: Sequence[str], after: After) -> None:
        self.lines = lines
        self._lanes: dict[str, list[int]] = {}
        self._before: dict[int, frozenset[int]] = {}
        for number, line in enumerate(lines, 1):
            if not (actor := actor_of(line)):
                continue
            lane = self._lanes.setdefault(actor, [])
            direct = [*lane[-1:], *after.get(number, ())]
            self._before[number] = frozenset(direct).union(*(self._before[cause] for cause in direct))
            lane.append(number)

    @cached_property
    def meetings(self) -> Mapping[Encounter, tuple[Place, ...]]:
        """The lines that can meet, and where."""
        places: dict[Encounter, list[Place]] = {}
        for first_lane, then_lane in permutations(self._lanes.values(), 2):
            for place in self._places(first_lane, then_lane):
                meeting = Encounter(self.lines[place.first - 1], self.lines[place.then - 1])
                places.setdefault(meeting, []).append(place)
        return {meeting: tuple(where) for meeting, where in places.items()}

    @cached_property
    def waits(self) -> Mapping[Encounter, tuple[Place, ...]]:
        """The lines that can come while another actor waits for its own, each with the meeting that it takes: the
        waiting actor also waits until the other actor's next action has begun."""
        places: dict[Encounter, list[Place]] = {}
        last_of = {number: last for lane in self._lanes.values() for last, number in pairwise(lane)}
        for place in (place for where in self.meetings.values() for place in where):
            if place.first in last_of:
                meanwhile = self.lines[last_of[place.first] - 1]
                places.setdefault(Encounter(meanwhile, self.lines[place.then - 1]), []).append(place)
        return {meeting: tuple(where) for meeting, where in places.items()}

    def _places(self, first_lane: Sequence[int], then_lane: Sequence[int]) -> Iterator[Place]:
        """The places where an action of the first lane can begin, followed by one of the other lane."""
        next_of = dict(pairwise(first_lane))
        last_of = {number: last for last, number in pairwise(then_lane)}
        for first in first_lane:
            for then in then_lane:
                too_early = then in self._before[first]
                next_is_between = next_of.get(first, 0) in self._before[then]
                last_is_between = first in self._before.get(last_of.get(then, 0), ())
                if not (too_early or next_is_between or last_is_between):
                    yield Place(first, then)

    def with_meeting(self, place: Place, rng: Random) -> tuple[int, ...]:
        """An order in which the two meet; everything else in any order that may be.

        Args:
            place: one of `meetings`.
            rng: only its `random()` is used.
        """
        first, then = place
        before_both = {n for n in self._before[then] if n != first and first not in self._before[n]}
        stages = dict.fromkeys(self._before, 4)
        stages |= dict.fromkeys(self._before[then], 2)
        stages |= dict.fromkeys(before_both | self._before[first], 0)
        stages |= {first: 1, then: 3}
        left, order = dict.fromkeys(self._before), list[int]()
        while left:
            free = [number for number in left if left.keys().isdisjoint(self._before[number])]
            earliest = min(stages[number] for number in free)
            order.append(pick(rng, [number for number in free if stages[number] == earliest]))
            del left[order[-1]]
        return tuple(order)


def meetings_of(lines: Iterable[str]) -> Iterator[Encounter]:
    """The lines that have met, of those that began, in this order."""
    begun = [line for line in lines if actor_of(line)]
    for pair in combinations(sorted(actors_of(begun)), 2):
        theirs = [line for line in begun if actor_of(line) in pair]
        yield from (Encounter(*met) for met in pairwise(theirs) if actor_of(met[0]) != actor_of(met[1]))


class InterleavingStrategy:
    """Adds turns to tests of several actors, so that their actions meet in an order that was not seen.

    Args:
        pool: of abstract tests.
        turn_wait: how long an actor waits for its turn at most, as the testbench declares it.
    """

    name = "interleaving"

    def __init__(self, pool: Pool, turn_wait: Sampler) -> None:
        self._pool = pool
        self._waits_s = [wait_s for wait_s in turn_wait.simple_values() if wait_s > 0.0]
        self._orders: dict[int, Order] = {}
        self._met: Counter[Encounter] = Counter()
        self._learned = 0

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Strategy`."""
        if not (self._pool.tests and self._waits_s and archive.open):
            return []
        for entry in archive.entries[self._learned :]:
            self._met.update(meetings_of(entry.test.lines[number] for number in entry.observation.begun))
        self._learned = len(archive.entries)
        met = self._met.copy()
        proposals = [self._proposal(archive, met, rng) for _ in range(count)]
        return [proposal for proposal in proposals if proposal is not None]

    def _proposal(self, archive: Archive, met: Counter[Encounter], rng: Random) -> Proposal | None:
        aim = self._aim(archive, rng)
        number, places = aim[:2] if aim else self._rarest(met, rng)
        if not places:
            return None
        order, lines = self._order(number).with_meeting(pick(rng, places), rng), self._pool.tests[number].lines
        met.update(meetings_of(lines[action - 1] for action in order))
        # Without an aim, the time that they wait for their turns is drawn: a point may need a short wait.
        wait_s = pick(rng, self._waits_s) if aim else None
        return Proposal(self._draft(number, order, wait_s), self.name, (aim[2],) if aim else ())

    def _aim(self, archive: Archive, rng: Random) -> tuple[int, Sequence[Place], Point] | None:
        """A test, where actions meet in it, and the open bin that this is for; None if none is known for it."""
        weights = {
            point: 1.0 / (1 + archive.tries[point])
            for point in archive.open
            if point[0] == "bin" and any(part in self._acts for part in point[2:])
        }
        if not weights:
            return None
        point = pick_weighted(rng, weights)
        wanted = [key for key in self._tests_of if _names(point[2:], *key)]
        if not wanted:
            return None
        meeting, is_wait = pick(rng, wanted)
        number = pick(rng, self._tests_of[meeting, is_wait])
        order = self._order(number)
        return number, (order.waits if is_wait else order.meetings)[meeting], point

    def _rarest(self, met: Counter[Encounter], rng: Random) -> tuple[int, Sequence[Place]]:
        """A test, and where those of its lines meet, or of some other tests, that have met least often."""
        numbers = dict.fromkeys(self._pool.any(rng) for _ in range(CANDIDATES))
        choices = [(number, meeting) for number in numbers for meeting in self._order(number).meetings]
        if not choices:
            return 0, ()
        fewest = min(met[meeting] for _, meeting in choices)
        number, meeting = pick(rng, [choice for choice in choices if met[choice[1]] == fewest])
        return number, self._order(number).meetings[meeting]

    def _draft(self, number: int, order: Sequence[int], wait_s: float | None) -> AbstractDraft:
        last = max(len(order) - 1, 1)
        values = {action: {TURN: round(place / last, 6)} for place, action in enumerate(order)}
        if wait_s is not None:
            values[RUN] = {TURN_WAIT_S: wait_s}
        return replace(self._pool.draft(number), values=values)

    def _order(self, number: int) -> Order:
        if number not in self._orders:
            test = self._pool.tests[number]
            self._orders[number] = Order(test.lines, self._pool.draft(number).after)
        return self._orders[number]

    @cached_property
    def _acts(self) -> frozenset[str]:
        """The acts in tests of the pool, with and without their actors."""
        lines = {line for test in self._pool.tests for line in test.lines if actor_of(line)}
        return frozenset(lines | {act_of(line) for line in lines})

    @cached_property
    def _tests_of(self) -> Mapping[tuple[Encounter, bool], Sequence[int]]:
        """The tests in which two lines can meet, or, with True, one can come while who does the other one waits."""
        numbers: dict[tuple[Encounter, bool], list[int]] = {}
        for number in range(0, len(self._pool.tests), 1 + len(self._pool.tests) // MAX_TESTS):
            order = self._order(number)
            for meeting in order.meetings:
                numbers.setdefault((meeting, False), []).append(number)
            for meeting in order.waits:
                numbers.setdefault((meeting, True), []).append(number)
        return numbers


def _names(parts: Sequence[str], meeting: Encounter, is_wait: bool) -> bool:
    """Whether a bin names both actions of a meeting, and no other actor as the one who is first: that is said of
    actions that meet, and of none that waits."""
    actors = [actor_of(line) for line in meeting]
    both = all(line in parts or act_of(line) in parts for line in meeting)
    first = [part for part in parts if part in actors]
    return both and (not first or (not is_wait and (len(first) > 1 or first[0] == actors[0])))
