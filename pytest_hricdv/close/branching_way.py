"""The way by branching: back to a decision point that few runs came through, and on from there in several ways.

The tests of a tree have their seed, their parameters of the run and their beginning in common, so they can be run by
forks (see `branching`). Each is a test like any other, with all of its parameters as chosen values.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from random import Random

from pytest_hricdv.close.archive import Archive, Entry
from pytest_hricdv.close.continuations import Continuation, disturbed, exchanged, redrawn
from pytest_hricdv.close.decision_points import Cell, CellArchive, WayThere, cell_of
from pytest_hricdv.close.way import Proposal
from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.cross_product import CrossProduct
from pytest_hricdv.disturbance import PREFIX
from pytest_hricdv.generate.abstract import AbstractTest, Draft
from pytest_hricdv.generate.concrete import ConcreteTest, Concretization, concretize, values_of
from pytest_hricdv.generate.rng import pick

NAME = "branching"

LEAVES = 4
"""So many tests part at one decision point: the more, the less does it cost to come there."""

DRAWN = 4
"""So many continuations are drawn for each test; those that aim at most are taken."""


@dataclass
class BranchingWay:
    """See the module.

    Args:
        ranges: of all commands, disturbances included.
        cross: the cross products of the testbench.
    """

    ranges: Concretization
    cross: Mapping[str, CrossProduct]
    name: str = NAME
    _tests: list[ConcreteTest] = field(default_factory=list)
    _cells: CellArchive = field(default_factory=CellArchive)
    _alike: dict[tuple[int, str], list[tuple[int, int]]] = field(default_factory=dict)
    _known: set[str] = field(default_factory=set)

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Way`."""
        for entry in archive.entries[len(self._tests) :]:
            self._learn(entry)
        found: list[Proposal] = []
        for cell in self._cells.choices(archive.open, rng):
            found += self._leaves(archive, cell, min(LEAVES, count - len(found)), rng)
            if len(found) == count:
                break
        return found

    def _learn(self, entry: Entry) -> None:
        """What a run adds: its decision points, and its actions, which need not be run again."""
        test = concretize(entry.test, self.ranges)
        self._tests.append(test)
        self._known.add(_content(test))
        places = []
        for point in entry.observation.decisions[1:]:  # before it, tests have nothing in common
            cell = cell_of(point, entry.test.lines, self.cross)
            places.append((cell, point))
            self._alike.setdefault(_likeness(cell, test, point.taken), []).append((entry.number, point.taken))
        self._cells.add(entry.number, places)

    def _leaves(self, archive: Archive, cell: Cell, count: int, rng: Random) -> list[Proposal]:
        """New tests that part in a cell: of those drawn, the ones that aim at most points that were seldom aimed at."""
        way = self._cells.cells[cell]
        entry, trunk = archive.entries[way.run], self._tests[way.run]
        found: dict[str, tuple[float, Proposal]] = {}
        for continuation in self._drawn(cell, way, DRAWN * count, rng):
            test = replace(trunk, actions=trunk.actions[: way.taken] + continuation.actions)
            content = _content(test)
            if content not in self._known and content not in found:
                aims = tuple(self._aims(cell, test, archive.open))
                worth = sum(1.0 / (1 + archive.tries[aim]) for aim in aims)
                found[content] = worth, Proposal(_draft(entry.test, way.taken, test, continuation), self.name, aims)
        best = sorted(found.values(), key=lambda each: -each[0])
        return [proposal for _, proposal in best[:count]]

    def _drawn(self, cell: Cell, way: WayThere, count: int, rng: Random) -> Iterator[Continuation]:
        trunk = self._tests[way.run]
        rest, ranges = trunk.actions[way.taken :], self.ranges.commands
        alike = self._alike[_likeness(cell, trunk, way.taken)]
        for _ in range(count):
            number, taken = pick(rng, alike)
            possible = disturbed(rest, ranges, rng), redrawn(rest, ranges, rng), exchanged(self._tests[number], taken)
            yield pick(rng, [each for each in possible if each is not None])

    def _aims(self, cell: Cell, test: ConcreteTest, open_points: Collection[Point]) -> Iterator[Point]:
        """The open bins that the test plans from the cell on."""
        planned: set[tuple[str, ...]] = set()
        commands = [action.command for action in test.actions if not action.command.startswith(PREFIX)]
        for name, product in self.cross.items():
            bins = [*product.planned(commands)] if product.planned is not None else []
            planned.update(("bin", name, *each) for each in bins[max(cell.interaction - 1, 0) :])
        return (point for point in open_points if any(point[:size] in planned for size in range(3, len(point))))


def _likeness(cell: Cell, test: ConcreteTest, taken: int) -> tuple[int, str]:
    """Decision points of tests that can change their rests: of interactions of one number, after the same command."""
    before = [action.command for action in test.actions[:taken] if not action.command.startswith(PREFIX)]
    return cell.interaction, before[-1] if before else ""


def _content(test: ConcreteTest) -> str:
    """What a run of the test depends on."""
    return replace(test, id="", suite="").to_json()


def _draft(trunk: AbstractTest, taken: int, test: ConcreteTest, continuation: Continuation) -> Draft:
    """The test of a leaf: all of its parameters are chosen, and it has the seed of the test whose beginning it has."""
    return Draft(
        trunk.target,
        trunk.beliefs if continuation.commanded else (),
        tuple(action.command for action in test.actions),
        trunk.plans if continuation.commanded else {},
        f"{trunk.id} up to command {taken}, then {continuation.what}",
        values_of(test),
        test.seed,
    )
