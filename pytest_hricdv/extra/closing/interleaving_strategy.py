"""The strategy `interleaving`: gives the actors of a test turns, so that two of their actions meet in a chosen order.

`ClosureGenerator` uses `InterleavingStrategy` if the model has several actors. Two actions of two actors *meet* if the
second is the next one of either actor to begin after the first. For an open bin that names the actions of two actors,
and perhaps who begins, the strategy proposes a test in which these can meet, or in which one can begin while the other
one's actor waits to begin it. Without such a bin, it takes the encounter that runs have had least often (as sequence
covering arrays do: D. R. Kuhn, J. M. Higdon, J. F. Lawrence, R. N. Kacker, Y. Lei: Combinatorial Methods for Event
Sequence Testing, ICST Workshops 2012).
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
"""Number of tests among which one with the rarest encounter is taken: enough for models with two actors, which have
few tests. Each costs a run of the model."""

MAX_TESTS = 512
"""Number of tests, evenly spread over the pool, that are searched for possible encounters: it takes some seconds."""


class Encounter(NamedTuple):
    """The lines of two actions that meet, in order."""

    first: str
    then: str


class EncounterPlace(NamedTuple):
    """The numbers (from 1) of two actions of a test that meet."""

    first: int
    then: int


class PartialOrder:
    """The partial order of the actions of a test: each actor's lane, and the causes of actions in other lanes.

    Args:
        after: action -> its causes, as in `pytest_hricdv.generate.actors`.
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
    def encounters(self) -> Mapping[Encounter, tuple[EncounterPlace, ...]]:
        """The lines that can meet -> the actions of the test that do."""
        places: dict[Encounter, list[EncounterPlace]] = {}
        for first_lane, then_lane in permutations(self._lanes.values(), 2):
            for place in self._places(first_lane, then_lane):
                encounter = Encounter(self.lines[place.first - 1], self.lines[place.then - 1])
                places.setdefault(encounter, []).append(place)
        return {encounter: tuple(where) for encounter, where in places.items()}

    @cached_property
    def waits(self) -> Mapping[Encounter, tuple[EncounterPlace, ...]]:
        """Two lines, of which the first can begin while the second one's actor waits to begin it -> the encounters that
        bring this about: the second line waits until the first actor's next action has begun."""
        places: dict[Encounter, list[EncounterPlace]] = {}
        last_of = {number: last for lane in self._lanes.values() for last, number in pairwise(lane)}
        for place in (place for where in self.encounters.values() for place in where):
            if place.first in last_of:
                meanwhile = self.lines[last_of[place.first] - 1]
                places.setdefault(Encounter(meanwhile, self.lines[place.then - 1]), []).append(place)
        return {encounter: tuple(where) for encounter, where in places.items()}

    def _places(self, first_lane: Sequence[int], then_lane: Sequence[int]) -> Iterator[EncounterPlace]:
        """The places where an action of the first lane can begin, followed by one of the other lane."""
        next_of = dict(pairwise(first_lane))
        last_of = {number: last for last, number in pairwise(then_lane)}
        for first in first_lane:
            for then in then_lane:
                too_early = then in self._before[first]
                next_is_between = next_of.get(first, 0) in self._before[then]
                last_is_between = first in self._before.get(last_of.get(then, 0), ())
                if not (too_early or next_is_between or last_is_between):
                    yield EncounterPlace(first, then)

    def with_encounter(self, place: EncounterPlace, rng: Random) -> tuple[int, ...]:
        """A random total order in which two actions meet.

        Args:
            place: the two actions, one of the values of `encounters`.
            rng: the random stream; only its `random()` is used.
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


def encounters_of(lines: Iterable[str]) -> Iterator[Encounter]:
    """The encounters in a run, from the lines that began, in order."""
    begun = [line for line in lines if actor_of(line)]
    for pair in combinations(sorted(actors_of(begun)), 2):
        theirs = [line for line in begun if actor_of(line) in pair]
        yield from (Encounter(*met) for met in pairwise(theirs) if actor_of(met[0]) != actor_of(met[1]))


class InterleavingStrategy:
    """Adds turns to tests of several actors, so that their actions meet as they have rarely or never met.

    Args:
        pool: the abstract tests.
        turn_wait: how long an actor waits for its turn at most, as the testbench declares it.
    """

    name = "interleaving"

    def __init__(self, pool: Pool, turn_wait: Sampler) -> None:
        self._pool = pool
        self._waits_s = [wait_s for wait_s in turn_wait.simple_values() if wait_s > 0.0]
        self._orders: dict[int, PartialOrder] = {}
        self._met: Counter[Encounter] = Counter()
        self._learned = 0

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Strategy`."""
        if not (self._pool.tests and self._waits_s and archive.open):
            return []
        for entry in archive.entries[self._learned :]:
            self._met.update(encounters_of(entry.test.lines[number] for number in entry.observation.begun))
        self._learned = len(archive.entries)
        met = self._met.copy()
        proposals = [self._proposal(archive, met, rng) for _ in range(count)]
        return [proposal for proposal in proposals if proposal is not None]

    def _proposal(self, archive: Archive, met: Counter[Encounter], rng: Random) -> Proposal | None:
        aim = self._aim(archive, rng)
        number, places = aim[:2] if aim else self._rarest(met, rng)
        if not places:
            return None
        order, lines = self._order(number).with_encounter(pick(rng, places), rng), self._pool.tests[number].lines
        met.update(encounters_of(lines[action - 1] for action in order))
        # Without a target, concretization draws how long actors wait for their turns: a point may need a short wait.
        wait_s = pick(rng, self._waits_s) if aim else None
        return Proposal(self._draft(number, order, wait_s), self.name, (aim[2],) if aim else ())

    def _aim(self, archive: Archive, rng: Random) -> tuple[int, Sequence[EncounterPlace], Point] | None:
        """A test, encounters in it, and the open bin that they target; None if no test is known for the drawn bin."""
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
        encounter, is_wait = pick(rng, wanted)
        number = pick(rng, self._tests_of[encounter, is_wait])
        order = self._order(number)
        return number, (order.waits if is_wait else order.encounters)[encounter], point

    def _rarest(self, met: Counter[Encounter], rng: Random) -> tuple[int, Sequence[EncounterPlace]]:
        """One of some random tests, and where those of its lines meet that have met least often."""
        numbers = dict.fromkeys(self._pool.any(rng) for _ in range(CANDIDATES))
        choices = [(number, encounter) for number in numbers for encounter in self._order(number).encounters]
        if not choices:
            return 0, ()
        fewest = min(met[encounter] for _, encounter in choices)
        number, encounter = pick(rng, [choice for choice in choices if met[choice[1]] == fewest])
        return number, self._order(number).encounters[encounter]

    def _draft(self, number: int, order: Sequence[int], wait_s: float | None) -> AbstractDraft:
        last = max(len(order) - 1, 1)
        values = {action: {TURN: round(place / last, 6)} for place, action in enumerate(order)}
        if wait_s is not None:
            values[RUN] = {TURN_WAIT_S: wait_s}
        return replace(self._pool.draft(number), values=values)

    def _order(self, number: int) -> PartialOrder:
        if number not in self._orders:
            test = self._pool.tests[number]
            self._orders[number] = PartialOrder(test.lines, self._pool.draft(number).after)
        return self._orders[number]

    @cached_property
    def _acts(self) -> frozenset[str]:
        """The acts in the pool's tests, with and without their actors."""
        lines = {line for test in self._pool.tests for line in test.lines if actor_of(line)}
        return frozenset(lines | {act_of(line) for line in lines})

    @cached_property
    def _tests_of(self) -> Mapping[tuple[Encounter, bool], Sequence[int]]:
        """(Encounter, False) -> the tests in which it can occur; with True, those in which it is one of `waits`."""
        numbers: dict[tuple[Encounter, bool], list[int]] = {}
        for number in range(0, len(self._pool.tests), 1 + len(self._pool.tests) // MAX_TESTS):
            order = self._order(number)
            for encounter in order.encounters:
                numbers.setdefault((encounter, False), []).append(number)
            for encounter in order.waits:
                numbers.setdefault((encounter, True), []).append(number)
        return numbers


def _names(parts: Sequence[str], encounter: Encounter, is_wait: bool) -> bool:
    """Whether a bin names both actions of a encounter and, if it says who begins, the first actor; a bin that says who
    begins is about actions that meet, not about waits."""
    actors = [actor_of(line) for line in encounter]
    both = all(line in parts or act_of(line) in parts for line in encounter)
    first = [part for part in parts if part in actors]
    return both and (not first or (not is_wait and (len(first) > 1 or first[0] == actors[0])))
