"""The way `parameters`: tests that came near to an open point are run again with other values of their parameters.

What the whole way brings is in docs/closure.md: at ten seeds, nothing beyond chance.
"""

from __future__ import annotations

from collections.abc import Sequence
from random import Random

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.archive import Archive, Entry
from pytest_hricdv.extra.closing.cross_entropy import adapted, elite_size
from pytest_hricdv.extra.closing.distance import PARENTS, nearest_runs
from pytest_hricdv.extra.closing.way import Proposal
from pytest_hricdv.generate.abstract import Draft
from pytest_hricdv.generate.chosen_values import RUN
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest, Concretization, concretize
from pytest_hricdv.generate.rng import pick


class ParameterWay:
    """Tests with values that are adapted to what came near.

    Args:
        commands: the ranges of all parameters, those of disturbances included.
    """

    name = "parameters"

    def __init__(self, commands: Concretization) -> None:
        self._commands = commands
        self._concrete: dict[int, ConcreteTest] = {}

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Way`."""
        near: dict[Point, list[Entry]] = {}
        for point in archive.open:
            if point[0] != "bin" and (runs := nearest_runs(point, archive)):
                near[point] = [entry for _, entry in runs]
        if not near:
            return []
        return [self._varied(point, near[point], rng) for point in (pick(rng, [*near]) for _ in range(count))]

    def _varied(self, point: Point, runs: Sequence[Entry], rng: Random) -> Proposal:
        elite = [self._values(entry) for entry in runs[: elite_size(len(runs))]]
        test = pick(rng, runs[:PARENTS]).test
        chosen: dict[int, dict[str, float]] = {}
        for number, line in enumerate(("", *test.lines)):
            samplers = self._commands.run if number == RUN else self._commands.commands[line]
            values = {
                name: adapted(sampler, [value for run in elite for value in run.get((line, name), ())], rng)
                for name, sampler in samplers.items()
            }
            if values:
                chosen[number] = values
        draft = Draft(test.target, test.beliefs, test.lines, test.plans, values=chosen)
        return Proposal(draft, self.name, (point,))

    def _values(self, entry: Entry) -> dict[tuple[str, str], list[float]]:
        """Command and parameter -> its values in a run; the command of the run's own parameters is empty."""
        concrete = self._concrete.get(entry.number)
        if concrete is None:
            concrete = self._concrete[entry.number] = concretize(entry.test, self._commands)
        values: dict[tuple[str, str], list[float]] = {}
        for action in (ConcreteAction("", concrete.run), *concrete.actions):
            for name, value in action.parameters.items():
                values.setdefault((action.command, name), []).append(value)
        return values
