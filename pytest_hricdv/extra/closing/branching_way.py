"""The way `branching`: back to a decision point of an earlier run, and on from there in several ways.

It is one that few runs came through, with open points near; or one of a run that came near to an open point: most
of what it takes has happened there already, and happens again.

The tests of a tree have their seed, their parameters of the run and their beginning in common, so they can be run by
forks (see `branching`). Each is a test like any other, with all of its parameters as chosen values.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from random import Random

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.cross_product import CrossProduct
from pytest_hricdv.disturbance import PREFIX
from pytest_hricdv.extra.closing.archive import Archive, Entry
from pytest_hricdv.extra.closing.cross_entropy import elite_size
from pytest_hricdv.extra.closing.decision_points import Cell, CellArchive, cell_of
from pytest_hricdv.extra.closing.distance import PARENTS, nearest_runs
from pytest_hricdv.extra.closing.way import Proposal
from pytest_hricdv.generate.abstract import AbstractTest, Draft
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest, Concretization, concretize, values_of
from pytest_hricdv.generate.rng import pick
from pytest_hricdv.generate.sampler import Sampler

NAME = "branching"

LEAVES = 4
"""So many tests part at one decision point: the more, the less does it cost to come there. Chosen: half a generation;
its effect was not measured. What the whole way brings is in docs/closure.md: at ten seeds, nothing beyond chance."""

CLIMBING = 0.5
"""So often a run that came near to an open point is gone back to, where there is one. Chosen; its effect was not
measured."""

DRAWN = 4
"""So many continuations are drawn for each test; those with most targets are taken. Chosen; its effect was not
measured."""


Actions = tuple[ConcreteAction, ...]
Ranges = Mapping[str, Mapping[str, Sampler]]
"""Command line -> the ranges of its parameters."""


@dataclass(frozen=True)
class Continuation:
    """The rest of a test.

    Args:
        actions: from the decision point on.
        what: it is, in a few words that complete "up to command 3, then ...".
        commanded: it has the same commands as the rest that it replaces, but for disturbances.
    """

    actions: Actions
    what: str
    commanded: bool = True


@dataclass(frozen=True)
class _Place:
    """Where a test parts from a run: after so many of its actions.

    Args:
        targets: what it is to come nearer to; without any, these are the bins that it plans.
        elite: the runs that came nearest to it: their rests, too, may be what it takes.
    """

    run: int
    taken: int
    cell: Cell
    targets: tuple[Point, ...] = ()
    elite: tuple[int, ...] = ()


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
    _places: list[list[_Place]] = field(default_factory=list)
    _cells: CellArchive = field(default_factory=CellArchive)
    _alike: dict[tuple[int, str], list[_Place]] = field(default_factory=dict)
    _known: set[str] = field(default_factory=set)

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Way`."""
        for entry in archive.entries[len(self._tests) :]:
            self._learn(entry)
        proposals: list[Proposal] = []
        for cell in self._cells.choices(archive.open, rng):
            way = self._cells.cells[cell]
            place = self._near(archive, rng) or _Place(way.run, way.taken, cell)
            proposals += self._leaves(archive, place, min(LEAVES, count - len(proposals)), rng)
            if len(proposals) == count:
                break
        return proposals

    def _learn(self, entry: Entry) -> None:
        """What a run adds: its decision points, and its actions, which need not be run again."""
        test = concretize(entry.test, self.ranges)
        self._tests.append(test)
        self._known.add(_content(test))
        # Before the first one, tests have nothing in common.
        points = [(cell_of(point, entry.test.lines, self.cross), point) for point in entry.observation.decisions[1:]]
        self._cells.add(entry.number, points)
        self._places.append([_Place(entry.number, point.taken, cell) for cell, point in points])
        for place in self._places[-1]:
            self._alike.setdefault(self._likeness(place), []).append(place)

    def _near(self, archive: Archive, rng: Random) -> _Place | None:
        """A decision point of a run that came near to an open point, from time to time."""
        near = {point: runs for point in archive.open if point[0] != "bin" and (runs := nearest_runs(point, archive))}
        if not near or rng.random() >= CLIMBING:
            return None
        point = pick(rng, [*near])
        nearest = [entry.number for _, entry in near[point]]
        elite, places = tuple(nearest[: elite_size(len(nearest))]), self._places[pick(rng, nearest[:PARENTS])]
        return replace(pick(rng, places), targets=(point,), elite=elite) if places else None

    def _leaves(self, archive: Archive, place: _Place, count: int, rng: Random) -> list[Proposal]:
        """Tests that part at a place: of those drawn, the ones with most targets that were seldom tried."""
        trunk, test = archive.entries[place.run].test, self._tests[place.run]
        drawn: dict[str, tuple[float, Proposal]] = {}
        for continuation in self._drawn(place, DRAWN * count, rng):
            leaf = replace(test, actions=test.actions[: place.taken] + continuation.actions)
            content = _content(leaf)
            if content not in self._known and content not in drawn:
                targets = place.targets or tuple(self._planned(place, leaf, archive.open))
                worth = sum(1.0 / (1 + archive.tries[target]) for target in targets)
                drawn[content] = worth, Proposal(_draft(trunk, place.taken, leaf, continuation), self.name, targets)
        best = sorted(drawn.values(), key=lambda leaf: -leaf[0])
        return [proposal for _, proposal in best[:count]]

    def _drawn(self, place: _Place, count: int, rng: Random) -> Iterator[Continuation]:
        rest, ranges = self._tests[place.run].actions[place.taken :], self.ranges.commands
        alike = self._alike[self._likeness(place)]
        alike = [other for other in alike if other.run in place.elite] or alike
        for _ in range(count):
            other = pick(rng, alike)
            possible = (
                disturbed(rest, ranges, rng),
                redrawn(rest, ranges, rng),
                exchanged(self._tests[other.run], other.taken),
            )
            yield pick(rng, [continuation for continuation in possible if continuation is not None])

    def _likeness(self, place: _Place) -> tuple[int, str]:
        """Places from which tests can change their rests: in interactions of one number, after the same command."""
        before = _commands(self._tests[place.run].actions[: place.taken])
        return place.cell.interaction, before[-1] if before else ""

    def _planned(self, place: _Place, leaf: ConcreteTest, open_points: Collection[Point]) -> Iterator[Point]:
        """The open bins that a test plans from the place on."""
        planned: set[tuple[str, ...]] = set()
        for name, product in self.cross.items():
            bins = [*product.planned(_commands(leaf.actions))] if product.planned is not None else []
            planned.update(("bin", name, *bin_) for bin_ in bins[max(place.cell.interaction - 1, 0) :])
        return (point for point in open_points if any(point[:size] in planned for size in range(3, len(point))))


def _commands(actions: Sequence[ConcreteAction]) -> list[str]:
    return [action.command for action in actions if not action.command.startswith(PREFIX)]


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


def disturbed(rest: Actions, ranges: Ranges, rng: Random) -> Continuation | None:
    """The same with a disturbance now; None where the testbench has none."""
    names = [command for command in ranges if command.startswith(PREFIX)]
    if not names:
        return None
    name = pick(rng, names)
    return Continuation((ConcreteAction(name, _sampled(ranges[name], rng)), *rest), name)


def redrawn(rest: Actions, ranges: Ranges, rng: Random) -> Continuation | None:
    """The same with all parameters drawn anew; None where there are none."""
    if not any(action.parameters for action in rest):
        return None
    drawn = (ConcreteAction(action.command, _sampled(ranges[action.command], rng)) for action in rest)
    return Continuation(tuple(drawn), "other values")


def exchanged(other: ConcreteTest, taken: int) -> Continuation:
    """The rest of another test, after so many actions of it."""
    return Continuation(other.actions[taken:], f"the rest of {other.id}", commanded=False)


def _sampled(samplers: Mapping[str, Sampler], rng: Random) -> dict[str, float]:
    return {name: sampler.sample(rng) for name, sampler in samplers.items()}
