"""The model's scripts: every abstract test that some beliefs make the model give, by the interactions that it plans."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from random import Random
from typing import NamedTuple

from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.extra.closing.cross_entropy import SMOOTHING
from pytest_hricdv.extra.closing.interactions import Planned, RunValues, Treatment, begins, disturbed
from pytest_hricdv.generate.abstract import Draft, Plans
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.chosen_values import RUN
from pytest_hricdv.generate.model import Exploration, ExploredRun
from pytest_hricdv.generate.rng import random_index, weighted


class Slot(NamedTuple):
    """What an interaction plans: the first coordinates of a bin of a cross product."""

    product: str
    planned: Bin


class Scripts:
    """The scripts of an explored model.

    Args:
        exploration: of the model: all of its runs, or those that are known.
        space: the belief space.
        planned: `planned` of each cross product that has it.
    """

    def __init__(self, exploration: Exploration, space: BeliefSpace, planned: Mapping[str, Planned]) -> None:
        self.exploration = exploration
        self.planned = dict(planned)
        self._space = space
        self._slots: dict[int, tuple[Slot, ...]] = {}

    @property
    def runs(self) -> Sequence[ExploredRun]:
        """The scripts, those of few beliefs first."""
        return self.exploration.runs

    def slots(self, number: int) -> tuple[Slot, ...]:
        """What the interactions of a script plan, cross product by cross product, each in order."""
        found = self._slots.get(number)
        if found is None:
            lines = self.runs[number].lines
            found = tuple(
                Slot(product, tuple(each)) for product, planned in self.planned.items() for each in planned(lines)
            )
            self._slots[number] = found
        return found

    @cached_property
    def by_slot(self) -> dict[Slot, list[int]]:
        """The scripts in which an interaction plans this."""
        found: dict[Slot, list[int]] = {}
        for number in range(len(self.runs)):
            for slot in dict.fromkeys(self.slots(number)):
                found.setdefault(slot, []).append(number)
        return found

    @cached_property
    def by_plan(self) -> dict[tuple[str, str], list[int]]:
        """The scripts for which the model executes a plan: agent and label -> numbers."""
        plans = self.exploration.plans
        found: dict[tuple[str, str], list[int]] = {plan: [] for plan in plans}
        for number, run in enumerate(self.runs):
            for place, plan in enumerate(plans):
                if run.plans >> place & 1:
                    found[plan].append(number)
        return found

    def drawn_beliefs(self, shares: Mapping[str, float], rng: Random) -> tuple[str, ...]:
        """A belief of each group, or none of it, drawn as often as wanted but so that none is ruled out.

        Args:
            shares: belief -> how often it is wanted, from 0 to 1.
            rng: of which only `random()` is used.
        """
        chosen = []
        for group in (self._space.start, *self._space.groups.values()):
            wanted: dict[str, float] = {belief: shares.get(belief, 0.0) for belief in group}
            wanted[""] = max(0.0, 1.0 - sum(wanted.values())) if group != self._space.start else 0.0
            even = (1.0 - SMOOTHING) / len(wanted)
            chosen.append(weighted(rng, {belief: SMOOTHING * share + even for belief, share in wanted.items()}))
        return tuple(belief for belief in chosen if belief)

    def of_beliefs(self, beliefs: Sequence[str]) -> int:
        """The script that the most of these beliefs, and the fewest others, lead to."""
        bits = sum(self._space.bits[belief] for belief in beliefs)
        runs = self.runs
        return max(
            range(len(runs)),
            key=lambda number: (
                (runs[number].beliefs & bits).bit_count() - 2 * (runs[number].beliefs & ~bits).bit_count()
            ),
        )

    def commands(self, slot: Slot) -> int:
        """How many commands an interaction has in which this is planned: in the first such script."""
        number = self.by_slot[slot][0]
        first = self.first(number, slot.product)
        place = [each for each in self.slots(number) if each.product == slot.product].index(slot)
        return (*first, len(self.runs[number].lines))[place + 1] - first[place]

    def any(self, rng: Random) -> int:
        """Any script."""
        return random_index(rng, len(self.runs))

    def draft(
        self, number: int, product: str = "", treatments: Sequence[Treatment] = (), run_values: RunValues = ()
    ) -> Draft:
        """The test of a script.

        Args:
            number: of the script.
            product: the cross product whose interactions are disturbed.
            treatments: of each of them, in order.
            run_values: parameters of the run as a whole; the others are drawn.
        """
        run = self.runs[number]
        lines, values = run.lines, dict[int, dict[str, float]]()
        if any(treatments):
            lines, values = disturbed(run.lines, self.first(number, product), treatments)
        if run_values:
            values[RUN] = dict(run_values)
        beliefs = self.exploration.belief_set(run.beliefs)
        return Draft(self._space.target(beliefs), beliefs, lines, self._plans(run), values=values)

    def first(self, number: int, product: str) -> tuple[int, ...]:
        """Where the interactions of a script begin; a script without any is one interaction as a whole."""
        planned = self.planned.get(product)
        return (begins(self.runs[number].lines, planned) if planned is not None else ()) or (0,)

    def _plans(self, run: ExploredRun) -> Plans:
        plans: dict[str, list[str]] = {agent: [] for agent, _ in self.exploration.plans}
        for place, (agent, label) in enumerate(self.exploration.plans):
            if run.plans >> place & 1:
                plans[agent].append(label)
        return {agent: tuple(sorted(labels)) for agent, labels in sorted(plans.items())}
