"""`shrink` reduces a failing test to a short one with the same failure, for `--hri-shrink` and for causes.

Actions are dropped first, by delta debugging (A. Zeller, R. Hildebrandt: Simplifying and Isolating Failure-Inducing
Input, IEEE TSE 28(2), 2002): whole interactions before single actions, or, with several actors, all actions of an actor
before single ones, and then their interleaving is simplified. Then the remaining parameters get simpler values (see
`shrink_candidates`), all at once if the test still fails. Both steps repeat until nothing changes any more. Failures
with the same signature (`failure_signature`) are the same.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from math import floor, log10
from typing import TypeVar

from pytest_hricdv.experiments.budget import Budget, BudgetSpentError, Ended
from pytest_hricdv.generate.actors import TURN, TURN_WAIT_S, actor_of
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest, Concretization
from pytest_hricdv.generate.sampler import Sampler, Sometimes, Uniform

T = TypeVar("T")

_SIGNIFICANT_DIGITS = (1, 2, 3)  # of simpler values, tried in this order

Places = Sequence[int]
"""Positions of actions in a test, from 0."""

#: The place of a parameter: the number of its action (None: a parameter of the run), and its name.
Spot = tuple[int | None, str]


@dataclass(frozen=True)
class Shrunk:
    """The shortest failing test found, the runs and the wall time (s) it took, and why shrinking ended."""

    test: ConcreteTest
    runs: int
    wall_s: float
    ended: Ended


def shrink(
    test: ConcreteTest,
    space: Concretization,
    fails: Callable[[ConcreteTest], bool],
    budget: Budget,
    on_progress: Callable[[ConcreteTest], None] = lambda test: None,
) -> Shrunk:
    """Shrink a test. Deterministic, unless the time limit ends it.

    Args:
        test: one that fails.
        space: the ranges that its parameters were drawn from; parameters without a range stay as they are.
        fails: runs a test and returns whether it has the same failure as the first.
        on_progress: called with each shorter failing test, so that it can be saved at once.

    Returns:
        The shortest test that failed, also if the budget was spent or the user pressed Ctrl-C.
    """
    shrinker = _Shrinker(test, space, fails, budget, on_progress)
    ended: Ended = "done"
    try:
        shrinker.run()
    except BudgetSpentError as spent:
        ended = spent.ended
    except KeyboardInterrupt:
        ended = "interrupted"
    return Shrunk(shrinker.best, budget.used, budget.age_s, ended)


class _Shrinker:
    def __init__(
        self,
        test: ConcreteTest,
        space: Concretization,
        fails: Callable[[ConcreteTest], bool],
        budget: Budget,
        on_progress: Callable[[ConcreteTest], None],
    ) -> None:
        self.best = test
        self._space = space
        self._fails = fails
        self._budget = budget
        self._on_progress = on_progress
        self._seen = {test.to_json(): True}

    def run(self) -> None:
        """Shrink until nothing changes any more."""
        before = None
        while before != self.best:
            before = self.best
            self._drop(_lanes(self.best) if self.best.actors else _turns(self.best.actions))
            self._drop([[place] for place in range(len(self.best.actions))])
            self._simplify([spot for spot in self._spots() if spot[1] in (TURN, TURN_WAIT_S)])
            self._simplify(self._spots())
            self._simplify_one_by_one()

    def _is_failing(self, test: ConcreteTest) -> bool:
        key = test.to_json()
        if key not in self._seen:
            self._budget.spend()
            self._seen[key] = self._fails(test)
            if self._seen[key]:
                self.best = test
                self._on_progress(test)
        return self._seen[key]

    def _drop(self, parts: Sequence[Places]) -> None:
        """Delta debugging over parts of the actions: keep only one chunk, or leave one out; then smaller chunks."""
        whole = self.best
        if not parts or self._is_failing(whole.keep(())):
            return
        count = 2
        while len(parts) > 1:
            kept = self._reduce(whole, _chunks(parts, count))
            if kept is not None:
                parts, count = kept, max(2, min(count - 1, len(kept)))
            elif count < len(parts):
                count = min(2 * count, len(parts))
            else:
                return

    def _reduce(self, whole: ConcreteTest, chunks: list[Sequence[Places]]) -> Sequence[Places] | None:
        """The first of these that fails: one chunk, or all chunks but one."""
        without = [list(chain.from_iterable(chunks[:left] + chunks[left + 1 :])) for left in range(len(chunks))]
        for kept in (*chunks, *without):
            if self._is_failing(whole.keep(chain.from_iterable(kept))):
                return kept
        return None

    def _spots(self) -> list[Spot]:
        """The parameters that have a simpler value."""
        spots: list[Spot] = [(None, name) for name in sorted(self.best.run)]
        spots += [(place, name) for place, action in enumerate(self.best.actions) for name in sorted(action.parameters)]
        return [spot for spot in spots if self._candidates(spot)]

    def _candidates(self, spot: Spot) -> tuple[float, ...]:
        sampler = self._sampler(spot)
        return () if sampler is None else shrink_candidates(_value(self.best, spot), sampler)

    def _sampler(self, spot: Spot) -> Sampler | None:
        place, name = spot
        if place is None:
            return self._space.run.get(name)
        return self._space.commands.get(self.best.actions[place].command, {}).get(name)

    def _simplify(self, spots: Sequence[Spot]) -> None:
        """Give all of these parameters their simplest value at once; if that does not fail, try each half of them."""
        changed = self.best
        for spot in spots:
            changed = _with(changed, spot, self._candidates(spot)[0])
        if not spots or self._is_failing(changed):
            return
        if len(spots) > 1:
            half = len(spots) // 2
            self._simplify(spots[:half])
            self._simplify(spots[half:])

    def _simplify_one_by_one(self) -> None:
        """Try all simpler values of each parameter."""
        for spot in self._spots():
            for candidate in self._candidates(spot):
                if self._is_failing(_with(self.best, spot, candidate)):
                    break


def _lanes(test: ConcreteTest) -> list[Places]:
    """The actions in parts, one for each actor; disturbances are the last part."""
    actors = [actor_of(action.command) for action in test.actions]
    parts = [[place for place, actor in enumerate(actors) if actor == name] for name in (*test.actors, "")]
    return [part for part in parts if part]


def _turns(actions: Sequence[ConcreteAction]) -> list[Places]:
    """The places of the actions in parts, each of which begins with the command that the first one begins with.

    Disturbances begin no part: disturbances before the first command belong to the first part.
    """
    first = next((action.command for action in actions if action.disturbance is None), "")
    starts = [0, *(place for place, action in enumerate(actions) if place and action.command == first)]
    return [range(start, end) for start, end in pairwise([*starts, len(actions)])]


def _chunks(parts: Sequence[T], count: int) -> list[Sequence[T]]:
    """`count` chunks of lengths that differ by at most one."""
    cuts = [len(parts) * number // count for number in range(count + 1)]
    return [parts[start:end] for start, end in pairwise(cuts)]


def _value(test: ConcreteTest, spot: Spot) -> float:
    place, name = spot
    return (test.run if place is None else test.actions[place].parameters)[name]


def _with(test: ConcreteTest, spot: Spot, value: float) -> ConcreteTest:
    place, name = spot
    if place is None:
        return replace(test, run={**test.run, name: value})
    actions = list(test.actions)
    actions[place] = replace(actions[place], parameters={**actions[place].parameters, name: value})
    return replace(test, actions=tuple(actions))


def shrink_candidates(value: float, sampler: Sampler) -> tuple[float, ...]:
    """The values to try instead of this one, the simplest first; empty if nothing is simpler.

    First the sampler's simple values, then the value itself rounded to one, two or three significant digits. All of
    them are in the range. The candidates for a candidate are those before it in the list, so that shrinking ends.
    """
    simpler: list[float] = []
    for candidate in (*sampler.simple_values(), *_round(value, sampler)):
        if candidate == value:
            break
        if candidate not in simpler:
            simpler.append(candidate)
    return tuple(simpler)


def _round(value: float, sampler: Sampler) -> Iterator[float]:
    inside = sampler.then if isinstance(sampler, Sometimes) else sampler
    if not isinstance(inside, Uniform) or value == 0.0:
        return
    magnitude = floor(log10(abs(value)))
    for digits in _SIGNIFICANT_DIGITS:
        rounded = round(value, digits - 1 - magnitude)
        if inside.contains(rounded):
            yield rounded
