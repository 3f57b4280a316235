"""Minimal pairs: the passing test that is closest to a failing one, found by runs.

`PairSearch` makes a `NeighborSearch` for a cause, whose `decision` runs variations of the failing test, in the order of
`variations`, until one passes the requirements that the test violates. A variation that does not check them any more
shows little, and is taken only if there is no other. For a deciding value, its threshold is found by halving.

The divergence (`find_divergence`) is the first event at which the failing and the passing run differ. Runs are compared
stream by stream: the messages that one sender sends of one topic, or one signal. Numbers are left out, and repeated
events count once: after a change to the test all later times differ a little, and so do measured values and the number
of messages, which says nothing. The stream that differs first counts.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import chain, zip_longest

from pytest_hricdv.extra.diagnosis.failures import FAULT
from pytest_hricdv.extra.diagnosis.records import Decision, ShownEvent
from pytest_hricdv.extra.diagnosis.runs import Run, RunEvent, RunSummary
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

BEFORE, AFTER = 2, 4
"""Number of events shown before and after the runs diverge. Chosen: both lists fit on a screen side by side."""


MAX_VIOLATIONS = 3
"""Maximum number of violations among the shown events. Chosen: the first ones matter."""


@dataclass(frozen=True)
class Divergence:
    """The point where two runs diverge.

    Args:
        failing: events of the failing run around it.
        passing: events of the passing run around it.
        at: index of the first different event, from 0; None if there is none.
    """

    failing: tuple[ShownEvent, ...] = ()
    passing: tuple[ShownEvent, ...] = ()
    at: int | None = None


Pair = tuple[RunEvent | None, RunEvent | None]
"""Events of one stream that differ, of the failing and of the passing run; None if the stream has no more."""


def find_divergence(failing: RunSummary, passing: RunSummary) -> Divergence:
    """Find the point where both runs diverge."""
    runs = changes(failing), changes(passing)
    violated = [
        ShownEvent(time_s=round(time_s, 3), text=f"{name} is violated")
        for name, time_s in sorted(failing.times_s.items(), key=lambda entry: (entry[1], entry[0]))
    ][:MAX_VIOLATIONS]
    pair = min(_differences(*runs), key=_time_s, default=None)
    if pair is None:
        return Divergence(failing=tuple(violated))
    places = [_place(run, event, _time_s(pair)) for run, event in zip(runs, pair, strict=True)]
    common = min(BEFORE, *places)
    shown = [
        [ShownEvent(time_s=round(event.time_s, 3), text=event.text) for event in run[place - common : place + AFTER]]
        for run, place in zip(runs, places, strict=True)
    ]
    after = sorted([*shown[0][common:], *violated], key=lambda event: event.time_s)
    return Divergence((*shown[0][:common], *after), tuple(shown[1]), common)


def changes(run: RunSummary) -> list[RunEvent]:
    """The events of a run, without those that repeat what the last one of their stream said."""
    last: dict[str, str] = {}
    kept = []
    for event in run.events:
        if last.get(event.stream) != event.value:
            kept.append(event)
        last[event.stream] = event.value
    return kept


def _differences(failing: Sequence[RunEvent], passing: Sequence[RunEvent]) -> Iterator[Pair]:
    """The first events that differ in each stream."""
    for stream in dict.fromkeys(event.stream for event in (*failing, *passing)):
        of_stream = ([event for event in run if event.stream == stream] for run in (failing, passing))
        for first, second in zip_longest(*of_stream):
            if first is None or second is None or first.value != second.value:
                yield first, second
                break


def _time_s(pair: Pair) -> float:
    return min(event.time_s for event in pair if event is not None)


def _place(run: Sequence[RunEvent], event: RunEvent | None, time_s: float) -> int:
    """The index of the event in a run, or where it would be."""
    if event is not None:
        return next(place for place, other in enumerate(run) if other is event)
    return sum(other.time_s < time_s for other in run)


NONE_PASSES = "fails with each change of one thing alone"
UNTRIED = "fails with each change that was tried; the budget is used up"

PRECISION = 0.01
"""A threshold is found to this share of the way between what passed first and the failing value. Chosen: seven runs."""


class SpentError(Exception):
    """The budget of runs is spent."""


Tried = tuple[Variation, RunSummary]


@dataclass
class NeighborSearch:
    """Looks for what decides that a test fails.

    Args:
        space: the ranges of the failing test's parameters.
        failing: the run of the failing test.
        wanted: the requirements that are to pass.
        budget: maximum number of runs.
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
