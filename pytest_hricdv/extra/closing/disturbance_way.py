"""The way of disturbances: interactions are disturbed so that probably they end as no run has ended yet.

What has led to a goal is done again where it may lead to an open bin; so is what can be put together from doses that
have mended what is lacking. Beside that, new doses are tried: of disturbances that promise to change what is lacking,
and of those that were rarely tried where the same usually comes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from functools import partial
from random import Random
from typing import TypeVar

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.aiming import Aiming, Option
from pytest_hricdv.extra.closing.archive import Archive
from pytest_hricdv.extra.closing.compositions import Compositions
from pytest_hricdv.extra.closing.cross_entropy import elite_size
from pytest_hricdv.extra.closing.experience import AT_THE_START, Experience
from pytest_hricdv.extra.closing.interactions import Dose, Goal, Treatment
from pytest_hricdv.extra.closing.nearness import nearest_runs
from pytest_hricdv.extra.closing.scripts import Scripts, Slot
from pytest_hricdv.extra.closing.way import Proposal
from pytest_hricdv.generate.rng import pick, random_index, weighted
from pytest_hricdv.generate.sampler import Sampler

T = TypeVar("T")

LIKELY = 0.01
"""What has led to a goal is done again, and what may lead there is put together, with at least this chance."""

UNLIKELY = 0.015
"""Of a new dose no less is expected."""

HELPFUL = 0.75
"""How often a new dose is one of a disturbance that promises to change what is lacking, instead of one that was rarely
tried."""

REDUCING = 0.4
"""How often it is a part of a treatment instead, where one is known that was not tried."""

VARYING = 0.35
"""So often a dose of what is put together is varied."""

LEAVING_OUT = 0.3
"""So often it is left out then."""

EAGERNESS = 2
"""Such disturbances are drawn in proportion to this power of how much they promise."""

EXPLORING = 0.4
"""So often an interaction has a new dose, whatever else is known."""

LEAST, MOST = 0.25, 0.5
"""Between so often and so often, by the share of open points that are no bins, all interactions of a test have one."""

CLIMBING = 0.6
"""So often what was rarely tried is tried where a run came near to an open point, where there is one; otherwise where
most is new."""

LED = 0.5
"""So often interactions are led there that usually end otherwise."""

CANDIDATES = 48
"""Of so many scripts, the one with most such interactions is taken."""

ENOUGH = 2
"""So often a disturbance is tried at the start of a run."""

MASKED = 0.75
"""So often such a disturbance is a known one, with another one that hides what it changes."""

Disturbances = Mapping[str, Mapping[str, Sampler]]
"""Name -> the ranges of its parameters."""


class DisturbanceWay:
    """Scripts of the model with disturbances.

    Args:
        scripts: of the model.
        experience: of all runs so far.
        disturbances: of the testbench.
    """

    name = "disturbances"

    def __init__(self, scripts: Scripts, experience: Experience, disturbances: Disturbances) -> None:
        self._scripts = scripts
        self._experience = experience
        self._disturbances = disturbances

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Way`."""
        if not self._disturbances or not self._scripts.runs:
            return []
        self._experience.learn(archive)
        treatments = _Treatments(self._scripts, self._experience, self._disturbances, archive, rng)
        aiming = Aiming(self._scripts, self._experience, archive, treatments.options)
        beside = sum(point[0] != "bin" for point in archive.open)
        trying = min(MOST, max(LEAST, beside / len(archive.open))) if beside else 0.0
        found = []
        for _ in range(count):
            aimed = aiming.aim(rng) if rng.random() >= trying else None
            if aimed is None:
                found.append(self._rarely_tried(treatments, archive, rng))
            else:
                draft = self._scripts.draft(aimed.script, aimed.product, aimed.treatments, aimed.run_values)
                found.append(Proposal(draft, self.name, aimed.aims))
        return found

    def _rarely_tried(self, treatments: _Treatments, archive: Archive, rng: Random) -> Proposal:
        """A script with disturbances that were rarely tried: for what is open beside the bins.

        Each is tried once before any is tried again where the same usually comes: what was not tried there may be all
        that is lacking.
        """
        near = self._near(treatments, archive, rng) if rng.random() < CLIMBING else None
        (script, product), goal, aims = near or (treatments.rarest_script(), None, ())
        first = self._scripts.first(script, product)
        ends = (*first[1:], len(self._scripts.runs[script].lines))
        slots: list[Slot | None] = [slot for slot in self._scripts.slots(script) if slot.product == product]
        chosen = [
            treatments.beside(slot, goal, end - begin) or treatments.rare(slot, end - begin, begin == first[0])
            for slot, begin, end in zip(slots or [None], first, ends, strict=True)
        ]
        return Proposal(self._scripts.draft(script, product, chosen), self.name, aims)

    def _near(
        self, treatments: _Treatments, archive: Archive, rng: Random
    ) -> tuple[tuple[int, str], Goal | None, tuple[Point, ...]] | None:
        """A script with interactions that usually end as in runs that came near to an open point, or with others, to be
        led there; how they ended; and this point."""
        near = {point: runs for point in archive.open if point[0] != "bin" and (runs := nearest_runs(point, archive))}
        if not near:
            return None
        point = pick(rng, [*near])
        elite = [entry for _, entry in near[point][: elite_size(len(near[point]))]]
        goal = self._experience.distinctive(elite, archive)
        if goal is None:
            return None
        usual = [slot for slot in self._scripts.by_slot if self._experience.usual(slot) == goal]
        led = [
            slot
            for slot in self._scripts.by_slot
            if slot not in usual and ("bin", slot.product, *slot.planned, *goal[1:]) in archive.best
        ]
        slots = led if led and rng.random() < LED else usual
        return (treatments.script_of(slots), goal, (point,)) if slots else None


class _Treatments:
    """The treatments of a generation."""

    def __init__(
        self, scripts: Scripts, experience: Experience, disturbances: Disturbances, archive: Archive, rng: Random
    ) -> None:
        self._scripts = scripts
        self._experience = experience
        self._disturbances = disturbances
        self._rng = rng
        self._doses = experience.doses.copy()
        self._tried = experience.tried.copy()
        self._has_others = any(point[0] != "bin" for point in archive.open)
        self._compositions = {name: Compositions(recipes) for name, recipes in experience.recipes.items()}
        self._unlocked = experience.first_of_many(archive)
        self._slots: dict[Goal | None, list[Slot]] = {}
        """What usually comes -> the interactions where it does."""
        for slot in scripts.by_slot:
            self._slots.setdefault(experience.usual(slot), []).append(slot)

    def _is_untried(self, usual: Goal | None) -> bool:
        return any(not self._tried[name, usual] for name in self._disturbances)

    def options(self, slot: Slot, goals: dict[Goal, float]) -> list[Option]:
        """See `aiming.Options`."""
        recipes, commands = self._experience.recipes[slot.product], self._scripts.commands(slot)
        if not goals:
            return [Option(0.0, (), partial(self.rare if self._has_others else self.single, slot))]
        if self._rng.random() < EXPLORING:
            return [Option(UNLIKELY * sum(goals.values()), tuple(goals), partial(self._new, slot, tuple(goals)))]
        found: list[Option] = []
        first = 0.0
        for goal, left in goals.items():
            left *= self._unlocked.get((recipes.usual(slot.planned), goal), 1)
            composed = self._compositions[slot.product].drawn(slot.planned, goal, commands, self._rng)
            best = recipes.best(slot.planned, goal, commands)
            if best is not None and best.chance >= LIKELY:
                found.append(Option(best.chance * left, (goal,), partial(_again, best.treatment)))
            if composed is not None and composed.chance >= LIKELY:
                found.append(Option(composed.chance * left, (goal,), partial(self._varied, composed.treatment)))
            first += max(recipes.first_chance(slot.planned, goal), UNLIKELY) * left
        found.append(Option(first, tuple(goals), partial(self._new, slot, tuple(goals))))
        return sorted(found, key=lambda option: -option.worth)

    def rarest_script(self) -> tuple[int, str]:
        """A script, and a cross product whose interactions usually end as those where most is new."""
        if not self._slots:
            return self._scripts.any(self._rng), next(iter(self._scripts.planned), "")
        new = {usual: sum(1.0 / (1 + self._tried[name, usual]) for name in self._disturbances) for usual in self._slots}
        slots = self._slots[max(new, key=lambda usual: new[usual])]
        return self.script_of(slots)

    def script_of(self, slots: Sequence[Slot]) -> tuple[int, str]:
        """A script with as many of these interactions as there is among some, and their cross product."""
        drawn = [pick(self._rng, slots) for _ in range(CANDIDATES)]
        candidates = [(pick(self._rng, self._scripts.by_slot[slot]), slot.product) for slot in drawn]
        wanted = frozenset(slots)
        return max(candidates, key=lambda each: sum(slot in wanted for slot in self._scripts.slots(each[0])))

    def beside(self, slot: Slot | None, goal: Goal | None, commands: int) -> Treatment | None:
        """What leads to a goal that does not come usually, with another dose; None where none is known."""
        if slot is None or goal is None or self._experience.usual(slot) == goal:
            return None
        found = self._compositions[slot.product].beside(slot.planned, goal, commands, self._rng)
        return None if found is None else self._varied(found, commands, False)

    def rare(self, slot: Slot | None, commands: int, is_first: bool) -> Treatment:
        """What was rarely tried: a new dose, or known ones of which one hides what another one changes."""
        is_known = slot is not None and not self._is_untried(self._experience.usual(slot))
        if slot is not None and is_known and self._rng.random() < MASKED:
            masked = self._compositions[slot.product].masked(slot.planned, commands, self._rng)
            if masked is not None:
                return self._varied(masked, commands, False)
        return self.single(slot, commands, is_first)

    def single(self, slot: Slot | None, commands: int, is_first: bool) -> Treatment:
        """A disturbance tried as rarely as any where the same usually comes, or at the start; at such a place."""
        usual = None if slot is None else self._experience.usual(slot)
        begins = [(name, AT_THE_START) for name in self._disturbances if is_first]
        new = [each for each in begins if self._tried[each] < ENOUGH]
        name, where = self._rarest([(name, usual) for name in self._disturbances], self._tried, new)
        if where == AT_THE_START:
            return (self._dose(name, 0),)
        return (self._dose(name, self._place(name, usual, commands)),)

    def _place(self, name: str, usual: Goal | None, commands: int) -> int:
        """After so many commands the disturbance was tried as rarely as any where the same usually comes."""
        places = [(name, usual, place) for place in range(1, commands + 1)]
        return self._rarest(places, self._doses)[2]

    def _rarest(self, choices: Sequence[T], counts: Counter[T], preferred: Sequence[T] = ()) -> T:
        """One of the choices that was taken as rarely as any; a preferred one, where one of these was."""
        rarest = min(counts[choice] for choice in (*preferred, *choices))
        rare = [choice for choice in preferred if counts[choice] == rarest]
        choice = pick(self._rng, rare or [choice for choice in choices if counts[choice] == rarest])
        counts[choice] += 1
        return choice

    def _new(self, slot: Slot, goals: Sequence[Goal], commands: int, is_first: bool) -> Treatment:
        """A new dose, or a part of several that have done something."""
        if self._rng.random() < REDUCING:
            reduced = self._compositions[slot.product].reduced(slot.planned, commands, self._rng)
            if reduced is not None:
                return reduced
        promise: Mapping[str, float] = {}
        if goals and self._rng.random() < HELPFUL:
            goal = pick(self._rng, goals)
            promise = self._compositions[slot.product].promise(self._disturbances, slot.planned, goal, commands)
        if not promise:
            return self.single(slot, commands, is_first)
        name = weighted(self._rng, {name: share**EAGERNESS for name, share in promise.items()})
        return (self._dose(name, self._place(name, self._experience.usual(slot), commands)),)

    def _varied(self, treatment: Treatment, commands: int, is_first: bool) -> Treatment:
        """What was put together; at times one dose is left out, as it may not be needed, or has another place and other
        parameters, as what it does together with others may depend on them."""
        if self._rng.random() >= VARYING:
            return treatment
        dose = pick(self._rng, treatment)
        if len(treatment) > 1 and self._rng.random() < LEAVING_OUT:
            return tuple(each for each in treatment if each != dose)
        other = self._dose(dose.name, 1 + random_index(self._rng, commands))
        return tuple(sorted(other if each == dose else each for each in treatment))

    def _dose(self, name: str, place: int) -> Dose:
        values = ((each, sampler.sample(self._rng)) for each, sampler in sorted(self._disturbances[name].items()))
        return Dose(place, name, tuple(values))


def _again(treatment: Treatment, commands: int, is_first: bool) -> Treatment:
    return treatment
