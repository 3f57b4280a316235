"""Shrinking: from a failing test to a short one that fails for the same reason.

Actions are dropped first, by delta debugging (A. Zeller, R. Hildebrandt: Simplifying and Isolating Failure-Inducing
Input, IEEE TSE 28(2), 2002), whole turns before single actions; then what parameters are left are simplified (see
`simpler`), all of them at once where that goes well. Both are repeated until nothing more can be taken away: shrinking
the result again changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from typing import TypeVar

from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest, Concretization
from pytest_hricdv.generate.sampler import Sampler

from .budget import Budget, Ended, SpentError
from .simpler import simpler

T = TypeVar("T")

#: Where a parameter stands: the place of its action (None: a parameter of the run), and its name.
Spot = tuple[int | None, str]


@dataclass(frozen=True)
class Shrunk:
    """What became of a failing test: the shortest one found, the runs it took (s of wall time), and why it ended."""

    test: ConcreteTest
    runs: int
    wall_s: float
    ended: Ended


def shrink(
    test: ConcreteTest,
    space: Concretization,
    fails: Callable[[ConcreteTest], bool],
    budget: Budget,
    better: Callable[[ConcreteTest], None] = lambda test: None,
) -> Shrunk:
    """Shrink a test. Deterministic, unless the seconds run out.

    Args:
        test: one that fails.
        space: the ranges that its parameters were drawn from; others are left as they are.
        fails: runs a test and says whether it fails for the same reason as the first.
        budget: of runs and seconds.
        better: told whenever a shorter test is found, so that it can be kept at once.

    Returns:
        The shortest test that was seen to fail, also where the budget was spent or Ctrl-C was pressed on the way.
    """
    shrinking = _Shrinking(test, space, fails, budget, better)
    ended: Ended = "done"
    try:
        shrinking.run()
    except SpentError as spent:
        ended = spent.ended
    except KeyboardInterrupt:
        ended = "interrupted"
    return Shrunk(shrinking.best, budget.used, budget.elapsed_s, ended)


class _Shrinking:
    def __init__(
        self,
        test: ConcreteTest,
        space: Concretization,
        fails: Callable[[ConcreteTest], bool],
        budget: Budget,
        better: Callable[[ConcreteTest], None],
    ) -> None:
        self.best = test
        self._space = space
        self._fails = fails
        self._budget = budget
        self._better = better
        self._seen = {test.to_json(): True}

    def run(self) -> None:
        """Until nothing changes any more."""
        before = None
        while before != self.best:
            before = self.best
            self._drop(_turns(self.best.actions))
            self._drop([[action] for action in self.best.actions])
            self._simplify(self._spots())
            self._simplify_on()

    def _is_failing(self, test: ConcreteTest) -> bool:
        key = test.to_json()
        if key not in self._seen:
            self._budget.spend()
            self._seen[key] = self._fails(test)
            if self._seen[key]:
                self.best = test
                self._better(test)
        return self._seen[key]

    def _drop(self, parts: Sequence[Sequence[ConcreteAction]]) -> None:
        """Delta debugging over parts of the actions: keep one chunk alone, or leave one out; then smaller chunks."""
        if not parts or self._is_failing(_of(self.best, ())):
            return
        count = 2
        while len(parts) > 1:
            kept = self._reduced(_chunks(parts, count))
            if kept is not None:
                parts, count = kept, max(2, min(count - 1, len(kept)))
            elif count < len(parts):
                count = min(2 * count, len(parts))
            else:
                return

    def _reduced(self, chunks: list[Sequence[Sequence[ConcreteAction]]]) -> Sequence[Sequence[ConcreteAction]] | None:
        """The first that fails of: a chunk alone, all but a chunk."""
        without = [list(chain.from_iterable(chunks[:left] + chunks[left + 1 :])) for left in range(len(chunks))]
        for kept in (*chunks, *without):
            if self._is_failing(_of(self.best, kept)):
                return kept
        return None

    def _spots(self) -> list[Spot]:
        """The parameters that something simpler is known for."""
        spots: list[Spot] = [(None, name) for name in sorted(self.best.run)]
        spots += [(place, name) for place, each in enumerate(self.best.actions) for name in sorted(each.parameters)]
        return [spot for spot in spots if self._candidates(spot)]

    def _candidates(self, spot: Spot) -> tuple[float, ...]:
        sampler = self._sampler(spot)
        return () if sampler is None else simpler(_value(self.best, spot), sampler)

    def _sampler(self, spot: Spot) -> Sampler | None:
        place, name = spot
        if place is None:
            return self._space.run.get(name)
        return self._space.commands.get(self.best.actions[place].command, {}).get(name)

    def _simplify(self, spots: Sequence[Spot]) -> None:
        """Give all of these parameters their simplest value at once, or else each half of them."""
        changed = self.best
        for spot in spots:
            changed = _with(changed, spot, self._candidates(spot)[0])
        if not spots or self._is_failing(changed):
            return
        if len(spots) > 1:
            half = len(spots) // 2
            self._simplify(spots[:half])
            self._simplify(spots[half:])

    def _simplify_on(self) -> None:
        """One by one, what the simplest value was too much for."""
        for spot in self._spots():
            for candidate in self._candidates(spot):
                if self._is_failing(_with(self.best, spot, candidate)):
                    break


def _turns(actions: Sequence[ConcreteAction]) -> list[Sequence[ConcreteAction]]:
    """The actions in parts, each of which begins with the command that the first one begins with."""
    starts = [place for place, action in enumerate(actions) if action.command == actions[0].command]
    return [actions[start:end] for start, end in pairwise([*starts, len(actions)])]


def _chunks(parts: Sequence[T], count: int) -> list[Sequence[T]]:
    """`count` chunks of lengths that differ by at most one."""
    cuts = [len(parts) * number // count for number in range(count + 1)]
    return [parts[start:end] for start, end in pairwise(cuts)]


def _of(test: ConcreteTest, parts: Iterable[Sequence[ConcreteAction]]) -> ConcreteTest:
    return replace(test, actions=tuple(chain.from_iterable(parts)))


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
