"""`ScheduleSearch`: searches for schedules under which a passing test fails.

`RaceHunt` gets tests with schedules from `draw`, and passes each run to `note`. A run shows which node executes which
statement when. If two nodes read and write the same data, the first is held up until the other one has run, which
reverses their order (see `pairs`). Each place to hold a node up is tried alone first, once for all pairs that begin
there. If the other node comes too late for that, a parameter of the test is changed so that it comes in time. A run has
one to three decisions: most races need one (S. Burckhardt, P. Kothari, M. Musuvathi, S. Nagarakatte: A Randomized
Scheduler with Probabilistic Guarantees of Finding Bugs, ASPLOS 2010).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import count
from operator import attrgetter, itemgetter
from random import Random
from typing import TypeVar

from pytest_hricdv.extra.schedules.pairs import DataConflict
from pytest_hricdv.extra.schedules.schedule_run import ScheduleRun
from pytest_hricdv.generate.concrete import ConcreteTest, Concretization
from pytest_hricdv.generate.rng import make_rng
from pytest_hricdv.generate.schedule import ScheduleDecision

MOST_DECISIONS = 3
"""Maximum number of decisions of a schedule, and so of one run."""

ONE = 0.6
"""The share of runs with one decision only."""

CAUSED = 0.75
"""Of moved actions, the share of those that the second statement of a pair follows; the others are any actions."""

LATE = 0.15
"""The share of random decisions that delay a message."""

HOLDS = 3
"""Number of places tried for holding the first thread of a pair up."""

DELAY_EACH = 3
"""Of the decisions that reverse pairs, each third is a delay; the others are holds."""

MAX_REPEATS = 20
"""Number of successive draws that repeat earlier ones, after which one is accepted."""

FIRST = 0.75
"""The share of pairs and choices tried at their first execution in a test, such as a start; others at any execution."""

Option = TypeVar("Option")

PlacePair = tuple[str, str]
"""The place of the statement that came first, and of the one that came next to the same data."""


@dataclass(frozen=True)
class ScheduleCandidate:
    """A test of the session that passes, the ranges of its parameters, and its usual run."""

    nodeid: str
    test: ConcreteTest
    space: Concretization
    usual: ScheduleRun


TestSchedule = tuple[ScheduleCandidate, ConcreteTest]
"""A test with a schedule, and the candidate that it was made of."""


@dataclass
class ScheduleSearch:
    """Draws schedules for tests, which hold a node up for `slowest_s` at most, and keeps which pairs were tried."""

    slowest_s: float
    seed: int
    seen: set[PlacePair] = field(default_factory=set)
    """Pairs in the order in which some run executed them."""
    near: set[PlacePair] = field(default_factory=set)
    """Those that a usual run executed so fast that a hold reverses them."""
    followed: set[tuple[PlacePair, tuple[str, ...]]] = field(default_factory=set)
    """Pairs of runs with schedules that led to further decisions, with the places held there: in another context than
    the first one it may matter."""
    tried: Counter[PlacePair] = field(default_factory=Counter)
    """Pairs whose first node was held up."""
    orders: Counter[tuple[str, int]] = field(default_factory=Counter)
    """Tries of choices: the place executed next in the usual run, and what went first instead."""
    further: list[tuple[int, ScheduleCandidate, ConcreteTest]] = field(default_factory=list)
    """Schedules with one more decision, about a pair that only a run with the others has."""
    inside: list[TestSchedule] = field(default_factory=list)
    """Schedules with one more decision while a node is held up."""
    combined: Counter[tuple[str, ...]] = field(default_factory=Counter)
    """Places of decisions -> how many of `inside` were tried."""
    reversals: int = 0
    """Tries to reverse pairs."""
    repeats: int = 0
    """Draws since the last new one."""
    drawn: set[tuple[str, tuple[ScheduleDecision, ...], str]] = field(default_factory=set)

    def note(
        self, run: ScheduleRun, candidate: ScheduleCandidate | None = None, test: ConcreteTest | None = None
    ) -> None:
        """Pairs that a run executed; with a schedule, those that are new or nearer lead to further decisions.

        Args:
            candidate: the candidate that the test was made of, if it has a schedule.
            test: the test with this schedule.
        """
        if candidate is None or test is None:
            self.near.update(conflict.pair for conflict in run.conflicts if self._is_near(conflict))
        elif len(test.schedule) < MOST_DECISIONS:
            self.further += [(place, candidate, further) for place, further in self._further(test, run)]
            self.further.sort(key=itemgetter(0))
            self.inside += [(candidate, further) for further in self._inside(test, run)]
        self.seen.update(conflict.pair for conflict in run.conflicts)

    def open_pairs(self) -> list[PlacePair]:
        """Pairs that came in one order only."""
        return sorted(pair for pair in self.seen if (pair[1], pair[0]) not in self.seen)

    def draw(self, candidates: Sequence[ScheduleCandidate]) -> Iterator[TestSchedule]:
        """Tests with schedules, without end; empty where no candidate has anything to order."""
        able = [candidate for candidate in candidates if candidate.usual.threads > 1 or candidate.usual.ready]
        for number in count() if able else ():
            rng = make_rng("schedules", self.seed, number)
            draw = ScheduleSearch._pair if number % 2 and self._has_untried_pair() else TURNS[number % len(TURNS)]
            made = draw(self, rng, able) or self._pair(rng, able) or self._at_random(rng, able)
            if self._is_new(made[1]):
                yield made

    def _has_untried_pair(self) -> bool:
        """Whether a single decision is still to be tried: large code has more of them than their share of the turns."""
        return any(not self.tried[pair] for pair in self.near)

    def _pop_further(self, *_: object) -> TestSchedule | None:
        return self.further.pop(0)[1:] if self.further else None

    def _pop_inside(self, *_: object) -> TestSchedule | None:
        """One with decisions at places that were combined least often, the fewest decisions and places."""
        if not self.inside:
            return None

        def rank(made: TestSchedule) -> tuple[int, ...]:
            places = _places(made[1])
            return self.combined[places], len(places), len({*places})

        best = min(self.inside, key=rank)
        self.inside.remove(best)
        self.combined[_places(best[1])] += 1
        return best

    def _is_new(self, test: ConcreteTest) -> bool:
        """Whether it was not drawn before; a few times it does not matter, or nothing might be left to draw."""
        key = test.id, test.schedule, repr(test.actions)
        is_new = key not in self.drawn or self.repeats >= MAX_REPEATS
        self.drawn.add(key)
        self.repeats = 0 if is_new else self.repeats + 1
        return is_new

    def _pair(self, rng: Random, candidates: Sequence[ScheduleCandidate]) -> TestSchedule | None:
        """The pair that was tried least, in a test that has it, if possible without a move."""
        found = [
            ((self.tried[conflict.pair], self._needs_move(conflict)), candidate, conflict)
            for candidate in candidates
            for conflict in candidate.usual.conflicts
        ]
        if not found:
            return None
        least = min(rank for rank, _, _ in found)
        pair = rng.choice([*dict.fromkeys(conflict.pair for rank, _, conflict in found if rank == least)])
        of_tests: dict[str, tuple[ScheduleCandidate, list[DataConflict]]] = {}
        for rank, candidate, conflict in found:
            if rank == least and conflict.pair == pair:
                of_tests.setdefault(candidate.nodeid, (candidate, []))[1].append(conflict)
        candidate, conflicts = rng.choice([*of_tests.values()])
        conflict = _choose_early(rng, conflicts)
        if (test := self._move(rng, candidate, conflict) if least[1] else candidate.test) is None:
            self.tried[pair] += 1
            return None
        decisions = self._reverse(conflict, candidate.usual)
        if not decisions or (least != (0, False) and rng.random() >= ONE):
            decisions += self._more(rng, candidate, rng.randint(1, MOST_DECISIONS - 1))
        return candidate, replace(test, schedule=_sort_decisions(decisions))

    def _order(self, rng: Random, candidates: Sequence[ScheduleCandidate]) -> TestSchedule | None:
        """Another choice of what runs next, before a place where that was tried least."""
        candidate = rng.choice([*candidates])
        choices: dict[tuple[str, int], list[int]] = {}
        for number, (ready, place) in enumerate(candidate.usual.ready, 1):
            for chosen in range(1, ready):
                choices.setdefault((place, chosen), []).append(number)
        if not choices:
            return None
        least = min(self.orders[choice] for choice in choices)
        choice = rng.choice([choice for choice in choices if self.orders[choice] == least])
        self.orders[choice] += 1
        decision = ScheduleDecision("order", "", _choose_early(rng, choices[choice]), choice=choice[1])
        return candidate, replace(candidate.test, schedule=(decision,))

    def _further(self, test: ConcreteTest, run: ScheduleRun) -> Iterator[tuple[int, ConcreteTest]]:
        """Which place of `_holds` is held, and the test with that decision, too: for each pair that is new or nearer,
        first those soon after a hold."""
        begin_s = min((held.time_s for held in run.held), default=0.0)
        context = tuple(sorted({decision.place for decision in test.schedule}))
        later: dict[PlacePair, DataConflict] = {}
        for conflict in sorted(run.conflicts, key=lambda conflict: abs(conflict.time_s - begin_s)):
            is_new = conflict.pair not in (self.near if self._is_near(conflict) else self.seen)
            if is_new and (conflict.pair, context) not in self.followed:
                later.setdefault(conflict.pair, conflict)
        self.followed.update((pair, context) for pair in later)
        for place in range(HOLDS):
            for conflict in later.values():
                if (held := _holds(conflict)[place]) is not None:
                    decision = self._preempt(held)
                    yield place, replace(test, schedule=_sort_decisions([*test.schedule, decision]))

    def _inside(self, test: ConcreteTest, run: ScheduleRun) -> Iterator[ConcreteTest]:
        """The test with one more decision while a node is held up: a hold of another one, too, or another choice of
        what runs next. Threads that execute the same code need that: their pairs are not new."""
        for held in run.held:
            begin, end = held.steps
            inside = {_holds(conflict)[0]: None for conflict in run.conflicts if begin <= conflict.step < end}
            decisions = [self._preempt(place) for place in inside if place is not None]
            for number in range(*held.choices):
                decisions += (
                    ScheduleDecision("order", "", number + 1, choice=one) for one in range(1, run.ready[number][0])
                )
            for decision in decisions:
                yield replace(test, schedule=_sort_decisions([*test.schedule, decision]))

    def _reverse(self, conflict: DataConflict, usual: ScheduleRun) -> list[ScheduleDecision]:
        """What lets the second one come before the first one; at the next times right after it, or earlier still.

        A hold ends once any other node has run, a delay outlasts those that a pair of two nodes does not need. What
        holds the first one up tries all pairs that begin with it.
        """
        tries, execution = self.tried[conflict.pair], (conflict.first, conflict.number)
        alike = (other for other in usual.conflicts if execution == (other.first, other.number))
        near = set() if self._needs_move(conflict) else {other.pair for other in alike if not self._needs_move(other)}
        self.tried.update(pair for pair in near | {conflict.pair} if self.tried[pair] == tries)
        self.reversals += 1
        held = _holds(conflict)[tries % HOLDS]
        is_delay = self.reversals % DELAY_EACH == 0 and not conflict.is_in_one_node
        return [] if held is None else [ScheduleDecision("delay" if is_delay else "preemption", *held, self.slowest_s)]

    def _preempt(self, execution: tuple[str, int]) -> ScheduleDecision:
        """Hold a node up before an execution of a place."""
        return ScheduleDecision("preemption", *execution, self.slowest_s)

    def _is_near(self, conflict: DataConflict) -> bool:
        return conflict.gap_s <= self.slowest_s

    def _needs_move(self, conflict: DataConflict) -> bool:
        """Whether the second one cannot come in between as the test is."""
        return conflict.is_in_one_node or not self._is_near(conflict)

    def _more(self, rng: Random, candidate: ScheduleCandidate, length: int) -> list[ScheduleDecision]:
        usual = candidate.usual
        if not usual.executed:
            return []
        near = [conflict for conflict in usual.conflicts if self._is_near(conflict)]
        made = []
        for _ in range(length):
            if usual.ready and rng.random() < 0.3:
                number = rng.randrange(len(usual.ready))
                chosen = rng.randrange(1, usual.ready[number][0])
                made.append(ScheduleDecision("order", "", number + 1, choice=chosen))
            elif usual.messages and rng.random() < LATE:
                topic = rng.choice(sorted(usual.messages))
                made.append(ScheduleDecision("delivery", topic, rng.randint(1, usual.messages[topic]), self.slowest_s))
            elif near and rng.random() < 0.5:
                conflict = rng.choice(near)
                made.append(self._preempt((conflict.first, conflict.number)))
            else:
                place = rng.choice([*usual.executed])
                made.append(self._preempt((place, rng.randint(1, usual.executed[place]))))
        return made

    def _at_random(self, rng: Random, candidates: Sequence[ScheduleCandidate]) -> TestSchedule:
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
            if name.endswith("_s")
            and (sampler := commands.get(action.command, {}).get(name)) is not None
            and sampler.contains(changed)
        ]
        if not options:
            return None
        last = max((number - 1 for time_s, number in candidate.usual.actions if time_s <= conflict.second_s), default=0)
        caused = [entry for entry in options if entry[0] == last and entry[2] < test.actions[last].parameters[entry[1]]]
        place, name, changed = rng.choice(caused if caused and rng.random() < CAUSED else options)
        action = replace(test.actions[place], parameters={**test.actions[place].parameters, name: changed})
        return replace(test, actions=(*test.actions[:place], action, *test.actions[place + 1 :]))


DrawSchedule = Callable[[ScheduleSearch, Random, Sequence[ScheduleCandidate]], TestSchedule | None]

TURNS: tuple[DrawSchedule, ...] = (
    ScheduleSearch._pop_further,
    ScheduleSearch._pop_inside,
    ScheduleSearch._pair,
    ScheduleSearch._order,
    ScheduleSearch._pop_inside,
    ScheduleSearch._pop_further,
    ScheduleSearch._pair,
    ScheduleSearch._pop_inside,
    ScheduleSearch._order,
    ScheduleSearch._pop_further,
    ScheduleSearch._pair,
    ScheduleSearch._pop_inside,
    ScheduleSearch._at_random,
)
"""The ways of drawing schedules, in turns; while a pair is untried, every other turn goes to pairs."""


def _holds(conflict: DataConflict) -> tuple[tuple[str, int] | None, ...]:
    """Where to hold a thread up for a pair, `HOLDS` places: before the first one, right after it, earlier still."""
    if conflict.is_in_one_node:
        return (conflict.awaited,) * HOLDS
    return (conflict.first, conflict.number), conflict.next, conflict.previous


def _choose_early(rng: Random, options: Sequence[Option]) -> Option:
    return options[0] if rng.random() < FIRST else rng.choice(options)


def _places(test: ConcreteTest) -> tuple[str, ...]:
    return tuple(decision.place for decision in test.schedule)


def _sort_decisions(decisions: Sequence[ScheduleDecision]) -> tuple[ScheduleDecision, ...]:
    """The decisions, each once; other orders last, which come first when decisions are taken away."""
    rank = attrgetter("kind", "place", "occurrence")
    return tuple(sorted(dict.fromkeys(decisions), key=lambda entry: (entry.kind == "order", rank(entry))))
