"""What runs have taught about interactions: the recipes of each cross product, and what was tried where."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.disturbance import PREFIX
from pytest_hricdv.extra.closing.archive import Archive, Entry
from pytest_hricdv.extra.closing.interactions import Effect, Goal, interactions_of
from pytest_hricdv.extra.closing.lack import apart
from pytest_hricdv.extra.closing.recipes import Recipes
from pytest_hricdv.extra.closing.scripts import Scripts, Slot
from pytest_hricdv.generate.abstract import AbstractTest

AT_THE_START: Goal = ("the start of a run",)
"""What is done there may do something that it does nowhere else."""


class Experience:
    """Learns from an archive, each run once.

    Args:
        scripts: of the model.
        run_values: what the parameters of the run as a whole are in a test.
    """

    def __init__(
        self, scripts: Scripts, run_values: Callable[[AbstractTest], Mapping[str, float]] = lambda test: {}
    ) -> None:
        self._scripts = scripts
        self._run_values = run_values
        sizes = {slot.product: len(slot.planned) for slot in scripts.by_slot}
        self.recipes: Mapping[str, Recipes] = {name: Recipes(sizes.get(name, 0)) for name in scripts.planned}
        self.tried: Counter[tuple[str, Goal | None]] = Counter()
        """How often a disturbance was tried by itself where this, or nothing known, usually comes of an interaction;
        before the first command, what usually comes is `AT_THE_START`."""
        self.doses: Counter[tuple[str, Goal | None, int]] = Counter()
        """The same after so many commands of the interaction, or of a test without any."""
        self._learned = 0

    def learn(self, archive: Archive) -> None:
        """Learn from the runs that came since the last time."""
        for entry in archive.entries[self._learned :]:
            test, hits = entry.test, entry.observation.hits
            run_values = tuple(sorted(self._run_values(test).items()))
            for product, planned in self._scripts.planned.items():
                found = interactions_of(test.lines, test.values, hits, product, planned)
                aims = self._aims(entry, product)
                self.recipes[product].learn(
                    each._replace(aims=aims.get(each.planned, ()), run_values=run_values) for each in found
                )
                for each in found:
                    if len(each.treatment) == 1:  # of several, one may hide what another one does
                        [dose] = each.treatment
                        self._count(dose.name, self.usual(Slot(product, each.planned)), dose.place)
            if not self._scripts.planned:
                for name, place in _places(test.lines):
                    self._count(name, None, place)
        self._learned = len(archive.entries)

    def _count(self, name: str, usual: Goal | None, place: int) -> None:
        where = usual if place else AT_THE_START
        self.tried[name, where] += 1
        self.doses[name, where, place] += 1

    def _aims(self, entry: Entry, product: str) -> dict[Bin, tuple[Goal, ...]]:
        size = self.recipes[product].coordinates
        aims: dict[Bin, tuple[Goal, ...]] = {}
        for kind, *point in entry.aims:
            if kind == "bin" and point[0] == product:
                planned = tuple(point[1 : 1 + size])
                aims[planned] = (*aims.get(planned, ()), (product, *point[1 + size :]))
        return aims

    def usual(self, slot: Slot) -> Goal | None:
        """What usually comes of an interaction without disturbances, by its own cross product."""
        effect = self.recipes[slot.product].usual(slot.planned) or ()
        return next((goal for goal in effect if goal[0] == slot.product), None)

    def distinctive(self, runs: Collection[Entry], archive: Archive) -> Goal | None:
        """What came of interactions in these runs more often than in all: what comes in the most more of them."""
        among, overall = (Counter(goal for run in each for goal in self._came(run)) for each in (runs, archive.entries))
        lift = {goal: among[goal] / len(runs) - overall[goal] / len(archive.entries) for goal in among}
        best = max(lift, key=lambda goal: (lift[goal], goal), default=None)
        return best if best is not None and lift[best] > 0.0 else None

    def _came(self, run: Entry) -> set[Goal]:
        hits = run.observation.hits
        return {
            (name, *hit[recipes.coordinates :]) for name, recipes in self.recipes.items() for hit in hits.get(name, ())
        }

    def open_goals(self, archive: Archive) -> dict[Slot, dict[Goal, Point]]:
        """What interactions may be aimed at: slot -> goal -> open bin.

        A bin that no script plans is a goal where what came of interactions was nearest to it.
        """
        found: dict[Slot, dict[Goal, Point]] = {}
        for point in archive.open:
            if point[0] == "bin":
                for slot, goal in self._slots(point):
                    found.setdefault(slot, {})[goal] = point
        return found

    def first_of_many(self, archive: Archive) -> Counter[tuple[Effect | None, Goal]]:
        """What usually comes, and a goal that no treatment has led to from there -> how many bins of it are open.

        What leads to one of them will probably lead to all.
        """
        many = Counter(
            (self.recipes[slot.product].usual(slot.planned), goal)
            for slot, goals in self.open_goals(archive).items()
            for goal in goals
        )
        for recipes in self.recipes.values():
            for each in recipes.seen:
                if each.treatment:
                    usual = recipes.usual(each.planned)
                    for goal in each.effect:
                        many.pop((usual, goal), None)
        return many

    def has_unplanned_bins(self, archive: Archive) -> bool:
        """Whether a bin is open of which no interaction is known that may be aimed at it."""
        return any(point[0] == "bin" and not self._slots(point) for point in archive.open)

    def _slots(self, point: Point) -> list[tuple[Slot, Goal]]:
        product, own = point[1], self.recipes.get(point[1])
        if own is None:
            return self._nearest(point[1:])
        slot = Slot(product, point[2 : 2 + own.coordinates])
        return [(slot, (product, *point[2 + own.coordinates :]))] if slot in self._scripts.by_slot else []

    def _nearest(self, goal: Goal) -> list[tuple[Slot, Goal]]:
        near: dict[float, list[Slot]] = {}
        for product, recipes in self.recipes.items():
            for planned, effects in recipes.effects.items():
                distances = [apart((each,), (goal,)) for effect in effects for each in effect if each[0] == goal[0]]
                slot = Slot(product, planned)
                if distances and slot in self._scripts.by_slot:
                    near.setdefault(min(distances), []).append(slot)
        return [(slot, goal) for slot in near[min(near)]] if near else []


def _places(lines: Sequence[str]) -> list[tuple[str, int]]:
    """The disturbances of a test, each with the number of commands before it."""
    found, place = [], 0
    for line in lines:
        if line.startswith(PREFIX):
            found.append((line.removeprefix(PREFIX), place))
        else:
            place += 1
    return found
