"""Aiming at open bins: which script, and how to disturb its interactions, so that probably many are hit at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from random import Random
from typing import NamedTuple

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.archive import Archive
from pytest_hricdv.extra.closing.experience import Experience
from pytest_hricdv.extra.closing.interactions import UNDISTURBED, Goal, RunValues, Treatment
from pytest_hricdv.extra.closing.scripts import Scripts, Slot
from pytest_hricdv.generate.rng import random_index

LEAST = 0.02
"""A bin is not aimed at with a smaller chance than this."""

CANDIDATES = 48
"""Of the scripts with a wanted interaction, so many are compared: there may be thousands."""


class Option(NamedTuple):
    """What may be done with an interaction.

    Args:
        worth: how many open bins it will probably hit.
        goals: that it is aimed at.
        treatment: makes up how to disturb it, where it has so many commands; and whether it is the first one.
    """

    worth: float
    goals: tuple[Goal, ...]
    treatment: Callable[[int, bool], Treatment]


Options = Callable[[Slot, dict[Goal, float]], list[Option]]
"""What may be done with an interaction that has these goals (goal -> how open it still is, 1 to 0), best first; where
it has none, what may be tried there by the way."""


class Aimed(NamedTuple):
    """A script with treatments for the interactions of a cross product, and the points that it is aimed at.

    Args:
        run_values: with which the likeliest of the treatments has worked before; empty where none has.
    """

    script: int
    product: str
    treatments: tuple[Treatment, ...]
    aims: tuple[Point, ...]
    run_values: RunValues = ()


class Aiming:
    """Aims a generation of tests at open bins. What one test will probably hit, the next ones are aimed at less.

    Args:
        scripts: of the model.
        experience: of all runs so far.
        archive: what is open.
        options: what may be done with an interaction.
    """

    def __init__(self, scripts: Scripts, experience: Experience, archive: Archive, options: Options) -> None:
        self._scripts = scripts
        self._recipes = experience.recipes
        self._options = options
        self._goals = experience.open_goals(archive)
        self._open = dict.fromkeys((point for goals in self._goals.values() for point in goals.values()), 1.0)
        self._known: dict[Slot, list[Option]] = {}

    def aim(self, rng: Random) -> Aimed | None:
        """Aim one test; None where nothing is worth it."""
        worth = {slot: options[0].worth for slot in self._goals if (options := self._of(slot))}
        worth = {slot: chance for slot, chance in worth.items() if chance > 0.0}
        if not worth:
            return None
        slot = max(worth, key=lambda each: worth[each] * (0.5 + rng.random()))
        scripts = self._scripts.by_slot[slot]
        candidates = [scripts[random_index(rng, len(scripts))] for _ in range(min(CANDIDATES, 2 * len(scripts)))]
        script = max(candidates, key=lambda number: self._worth(number, slot.product))
        return self._aimed(script, slot.product)

    def _of(self, slot: Slot) -> list[Option]:
        found = self._known.get(slot)
        if found is None:
            goals = {goal: self._open[point] for goal, point in self._goals.get(slot, {}).items()}
            found = self._known[slot] = self._options(slot, goals)
        return found

    def _worth(self, number: int, product: str) -> float:
        """How many open bins a script will probably hit."""
        used: dict[Slot, int] = {}
        worth = 0.0
        for slot in self._scripts.slots(number):
            if slot.product == product:
                options, place = self._of(slot), used.get(slot, 0)
                worth += options[place].worth if place < len(options) else 0.0
                used[slot] = place + 1
        return worth

    def _aimed(self, script: int, product: str) -> Aimed:
        first = self._scripts.first(script, product)
        ends = (*first[1:], len(self._scripts.runs[script].lines))
        slots = [slot for slot in self._scripts.slots(script) if slot.product == product]
        treatments: list[Treatment] = []
        aims: list[Point] = []
        known: list[tuple[float, RunValues]] = [(0.0, ())]
        for place, slot in enumerate(slots):
            options = self._of(slot)
            if not options:
                treatments.append(UNDISTURBED)
                continue
            worth, goals, treatment = options[0]
            treatments.append(treatment(ends[place] - first[place], place == 0))
            known += [(worth, found) for found in self._run_values(product, treatments[-1], goals)]
            points = [self._goals[slot][goal] for goal in goals]
            for point in points:
                self._open[point] *= 1.0 - min(worth / len(points), 1.0)
            aims += points
            self._known.pop(slot)
        return Aimed(script, product, tuple(treatments), tuple(aims), max(known, key=lambda each: each[0])[1])

    def _run_values(self, product: str, treatment: Treatment, goals: Sequence[Goal]) -> Iterator[RunValues]:
        """The parameters of runs in which doses of a treatment led to goals."""
        known = self._recipes[product].run_values
        return (known[dose, goal] for goal in goals for dose in treatment if (dose, goal) in known)
