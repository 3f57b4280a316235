"""Decision points of runs, where the person may do something else than they did; and the archive to choose from.

In the manner of Go-Explore (Ecoffet et al., arXiv 1901.10995): situations that are alike share a cell; a cell that
few runs came through, and that has open points near it, is likely to be returned to.
Visits weigh as in First return, then explore (Ecoffet et al., arXiv 2004.12919): 1 / sqrt(visits + 1).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from random import Random

import msgspec

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.cross_product import Bin, CrossProduct
from pytest_hricdv.disturbance import PREFIX
from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.generate.rng import weighted

NEAR_COORDINATES = 1
"""A bin is near to what an interaction plans if it differs in at most so many of the planned coordinates. Chosen: the
least that is not the bin itself; its effect was not measured."""


class DecisionPoint(msgspec.Struct, frozen=True):
    """Where a person asked what to do next.

    Args:
        taken: the number of actions before.
        time_s: when it was (s of simulated time).
        state: of the code under test; empty where it names none.
        awaited: the requirements with a trigger that was not decided yet.
    """

    taken: int
    time_s: float
    state: str = ""
    awaited: tuple[str, ...] = ()


def decision_points(result: CaseResult, state: str = "") -> tuple[DecisionPoint, ...]:
    """The decision points of a run, one for each action that began.

    Args:
        state: the message's field that names the state of the code under test, `topic.field`; empty if none does.
    """
    topic, _, name = state.partition(".")
    states = [
        (message.time_s, str(message.fields[name])) for message in result.record.messages if message.topic == topic
    ]
    return tuple(
        DecisionPoint(
            taken,
            time_s,
            next((value for since_s, value in reversed(states) if since_s <= time_s), ""),
            tuple(sorted(_awaited(result, time_s))),
        )
        for taken, time_s in enumerate(result.acted_s)
    )


def _awaited(result: CaseResult, time_s: float) -> Iterator[str]:
    for verdict in result.verdicts:
        if any(trigger.begin_s <= time_s < trigger.end_s for trigger in verdict.history):
            yield verdict.requirement


@dataclass(frozen=True)
class Cell:
    """Situations that are alike.

    Args:
        state: of the code under test.
        interaction: its number; 0 before the first one.
        planned: cross product -> what the present interaction plans up to now, sorted by name.
        awaited: as of `DecisionPoint`.
    """

    state: str
    interaction: int
    planned: tuple[tuple[str, Bin], ...]
    awaited: tuple[str, ...]


def cell_of(point: DecisionPoint, lines: Sequence[str], cross: Mapping[str, CrossProduct]) -> Cell:
    """The cell of a decision point.

    Args:
        lines: of the test.
        cross: the cross products of the testbench; those with `planned` tell interactions apart.
    """
    before = [line for line in lines[: point.taken] if not line.startswith(PREFIX)]
    plans: dict[str, tuple[Bin, ...]] = {}
    for name, product in cross.items():
        if product.planned is not None:
            plans[name] = tuple(tuple(bin_) for bin_ in product.planned(before))
    planned = tuple((name, bins[-1]) for name, bins in sorted(plans.items()) if bins)
    return Cell(point.state, max(map(len, plans.values()), default=0), planned, point.awaited)


class Neighbourhood:
    """Which open points are near to a cell: a step from its state, a bin like the planned one, or what is awaited.

    Args:
        open_points: that no run has hit.
    """

    def __init__(self, open_points: Iterable[Point]) -> None:
        self._steps: Counter[str] = Counter()
        self._awaited: Counter[str] = Counter()
        self._bins: dict[str, list[Bin]] = {}
        for kind, name, *coordinates in open_points:
            if kind == "transition":
                self._steps[name] += 1
            elif kind in ("verdict", "antecedent"):
                self._awaited[name] += 1
            elif kind == "bin":
                self._bins.setdefault(name, []).append(tuple(coordinates))
        self._near = cache(self._near_bins)

    def size(self, cell: Cell) -> int:
        """How many open points are near."""
        awaited = sum(self._awaited[requirement] for requirement in cell.awaited)
        return self._steps[cell.state] + awaited + sum(self._near(*planned) for planned in cell.planned)

    def _near_bins(self, name: str, planned: Bin) -> int:
        differing = (sum(map(str.__ne__, planned, bin_)) for bin_ in self._bins.get(name, ()))
        return sum(differ <= NEAR_COORDINATES for differ in differing)


@dataclass
class Path:
    """How to come to a cell in the least simulated time.

    Args:
        visits: how many runs came there.
        time_s: simulated time on the way (s).
        run: the number of the run that takes this way.
        taken: the number of its actions on the way.
    """

    visits: int
    time_s: float
    run: int
    taken: int


class CellArchive:
    """The cells that runs came through."""

    def __init__(self) -> None:
        self.cells: dict[Cell, Path] = {}

    def add(self, run: int, places: Iterable[tuple[Cell, DecisionPoint]]) -> None:
        """Add a run's decision points, in order; of several in one cell, the first is a visit."""
        first: dict[Cell, DecisionPoint] = {}
        for cell, point in places:
            first.setdefault(cell, point)
        for cell, point in first.items():
            path = self.cells.setdefault(cell, Path(0, math.inf, run, point.taken))
            path.visits += 1
            if point.time_s < path.time_s:
                path.time_s, path.run, path.taken = point.time_s, run, point.taken

    def weight(self, cell: Cell, near: Neighbourhood) -> float:
        """How worthwhile it is to return: the more open points are near, and the fewer runs came through."""
        return (1 + near.size(cell)) / math.sqrt(self.cells[cell].visits + 1)

    def choices(self, open_points: Iterable[Point], rng: Random) -> Iterator[Cell]:
        """All cells in random order: the greater its weight, the earlier probably comes a cell."""
        near = Neighbourhood(open_points)
        left = {cell: self.weight(cell, near) for cell in self.cells}
        while left:
            cell = weighted(rng, left)
            del left[cell]
            yield cell
