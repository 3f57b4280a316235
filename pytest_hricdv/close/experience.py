"""What runs have taught about interactions: the recipes of each cross product, and what was tried where."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

from pytest_hricdv.close.archive import Archive
from pytest_hricdv.close.interactions import interactions_of
from pytest_hricdv.close.recipes import Recipes
from pytest_hricdv.close.scripts import Scripts, Slot
from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.disturbance import PREFIX


class Experience:
    """Learns from an archive, each run once.

    Args:
        scripts: of the model.
    """

    def __init__(self, scripts: Scripts) -> None:
        self._scripts = scripts
        sizes = {slot.product: len(slot.planned) for slot in scripts.by_slot}
        self.recipes: Mapping[str, Recipes] = {name: Recipes(sizes.get(name, 0)) for name in scripts.planned}
        self.doses: Counter[tuple[str, int]] = Counter()
        """How often a disturbance was tried after so many commands of an interaction, or of a test."""
        self._learned = 0

    def learn(self, archive: Archive) -> None:
        """Learn from the runs that came since the last time."""
        for entry in archive.entries[self._learned :]:
            test, hits = entry.test, entry.observation.hits
            for product, planned in self._scripts.planned.items():
                found = interactions_of(test.lines, test.values, hits, product, planned)
                self.recipes[product].learn(found)
                self.doses.update((dose.name, dose.place) for each in found for dose in each.treatment)
            if not self._scripts.planned:
                self.doses.update(_places(test.lines))
        self._learned = len(archive.entries)

    def open_bins(self, archive: Archive) -> dict[Slot, list[Bin]]:
        """What is open: slot -> the rests of its bins."""
        found: dict[Slot, list[Bin]] = {}
        for point in archive.open:
            slot, rest = self.slot_of(point)
            if slot is not None:
                found.setdefault(slot, []).append(rest)
        return found

    def slot_of(self, point: Point) -> tuple[Slot | None, Bin]:
        """The slot of a bin that a script can plan, and the rest of the bin; None for other points."""
        if point[0] == "bin" and point[1] in self.recipes:
            size = self.recipes[point[1]].coordinates
            slot = Slot(point[1], point[2 : 2 + size])
            if slot in self._scripts.by_slot:
                return slot, point[2 + size :]
        return None, ()


def _places(lines: Sequence[str]) -> list[tuple[str, int]]:
    """The disturbances of a test, each with the number of commands before it."""
    found, place = [], 0
    for line in lines:
        if line.startswith(PREFIX):
            found.append((line.removeprefix(PREFIX), place))
        else:
            place += 1
    return found
