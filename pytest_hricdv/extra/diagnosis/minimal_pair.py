"""Minimal pairs: the passing test that is closest to a failing one, found by runs.

Variations of the test run one after the other until one passes what fails, as `variations` orders them. One that does
not check the requirement any more shows little, and is taken only where there is no other. Of a value that decides, its
threshold is looked for by halving.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field
from itertools import chain

from pytest_hricdv.extra.diagnosis.divergence import find_divergence
from pytest_hricdv.extra.diagnosis.failures import FAULT
from pytest_hricdv.extra.diagnosis.records import Decision
from pytest_hricdv.extra.diagnosis.runs import Run, RunSummary
from pytest_hricdv.extra.diagnosis.variations import (
    Variation,
    delay,
    sampler_of,
    value_of,
    values,
    variations,
    with_value,
)
from pytest_hricdv.generate.concrete import ConcreteTest, Concretization

NONE_PASSES = "fails with each change of one thing alone"
UNTRIED = "fails with each change that was tried; the budget is used up"

PRECISION = 0.01
"""A threshold is found to this share of the way between what passed first and the failing value. Chosen: seven runs."""


class SpentError(Exception):
    """No run is left."""


Tried = tuple[Variation, RunSummary]


@dataclass
class NeighborSearch:
    """Looks for what decides that a test fails.

    Args:
        test: that fails.
        space: the ranges of its parameters.
        failing: its run.
        wanted: the requirements that are to pass.
        run: runs a test.
        budget: most runs.
    """

    test: ConcreteTest
    space: Concretization
    failing: RunSummary
    wanted: Collection[str]
    run: Run
    budget: int
    used: int = 0
    neighbour: ConcreteTest | None = field(default=None, init=False)
    """The test that passes, once it is known."""
    _unchecked: Tried | None = field(default=None, init=False)
    """The first variation that passes because it does not check the requirement any more."""

    def decision(self, before: Iterable[Tried] = ()) -> Decision | None:
        """The deciding change; None if no run was made.

        Args:
            before: variations that have run before: they come first, and are not run again.
        """
        untried = self._runs(variations(self.test, self.space, self._actions_before()))
        try:
            passing = next(filter(self._passes, chain(before, untried)), None)
            is_spent = False
        except SpentError:
            passing, is_spent = None, True
        passing = passing or self._unchecked
        if passing is None:
            words = UNTRIED if is_spent else NONE_PASSES
            return Decision(words=words, test=self.test.id, runs=self.used) if self.used else None
        words = self._words(passing)
        if passing[0].kind == "disturbance" and (value := self._value_of_disturbance(passing[0])) is not None:
            words = f"{words}, or {self._words(value)}"
        return self._decision(passing, words)

    def _actions_before(self) -> list[int]:
        """The actions that had begun when what is wanted was violated, in this order."""
        times_s = [self.failing.times_s.get(name, math.inf) for name in self.wanted]
        return [number for time_s, number in self.failing.begun if time_s <= max(times_s, default=math.inf)]

    def _runs(self, untried: Iterable[Variation]) -> Iterator[Tried]:
        """Variations with their runs, those that come to an end. Raises SpentError if none is left."""
        for variation in untried:
            if self.used >= self.budget:
                raise SpentError
            self.used += 1
            result = self.run(variation.test)
            if result is not None:
                yield variation, result

    def _passes(self, tried: Tried) -> bool:
        """Whether a variation passes what is wanted, and nothing else has come to fail instead."""
        variation, result = tried
        if not set(result.violated) <= set(self.failing.violated) - set(self.wanted):
            return False
        if variation.kind == "disturbance" or set(self.wanted) - {FAULT} <= set(result.checked):
            return True
        self._unchecked = self._unchecked or tried
        return False

    def _value_of_disturbance(self, left_out: Variation) -> Tried | None:
        """Whether another value of its parameters does, or its coming at another time."""
        others = {action.command for action in left_out.test.actions}
        last = max(place for place, action in enumerate(self.test.actions) if action.command not in others)
        near = (
            variation
            for variation in values(self.test, self.space, [*range(last, -1, -1)])
            if variation.spot[0] is not None
        )
        try:
            return next(filter(self._passes, self._runs(near)), None)
        except SpentError:
            return None

    def _words(self, passing: Tried) -> str:
        """The words for the variation; for a value, from which value on the test passes."""
        variation, result = passing
        verb = "is" if len(self.wanted) == 1 else "are"
        reason = f", but only because {', '.join(self.wanted)} {verb} then never triggered"
        unchecked = reason if passing is self._unchecked else ""
        if variation.kind != "value":
            return f"{variation.words}{unchecked}"
        (variation, result), fails = self._threshold(passing)
        sampler = sampler_of(self.test, self.space, variation.spot)
        shown = str if sampler is None else sampler.format
        place, name = variation.spot
        owner = "the run" if place is None else self.test.actions[place].command
        side = "less" if variation.value < fails else "more"
        value = f"{name} of {owner} {shown(variation.value)} or {side}; it fails with {shown(fails)}"
        when = delay(self.test, self.failing, result)
        return f"{when} ({value}{unchecked})" if when else f"with {value}{unchecked}"

    def _threshold(self, passing: Tried) -> tuple[Tried, float]:
        """The value nearest to the failing one with which it passes, and the nearest with which it fails."""
        best, fails = passing, value_of(self.test, passing[0].spot)
        within = PRECISION * abs(best[0].value - fails)
        while abs(best[0].value - fails) > within:
            middle = with_value(self.test, self.space, best[0].spot, (best[0].value + fails) / 2)
            try:
                tried = next(self._runs([middle]), None)
            except SpentError:
                break
            if tried is not None and self._passes(tried):
                best = tried
            else:
                fails = middle.value
        return best, fails

    def _decision(self, passing: Tried, words: str) -> Decision:
        variation, result = passing
        self.neighbour = variation.test
        parting = find_divergence(self.failing, result)
        return Decision(
            words=words,
            kind=variation.kind,
            test=self.test.id,
            runs=self.used,
            failing=parting.failing,
            passing=parting.passing,
            differs_at=parting.at,
            concrete=self.space.describe(variation.test),
            untriggered=passing is self._unchecked,
        )
