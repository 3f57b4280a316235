"""The strategy `online`: the person decides during the run, as the agent of the model does, from what happens there.

What it decides is drawn by weights, with another target for each interaction: an option is likelier if it made such a
target likelier in earlier runs, and if it was seldom chosen.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from itertools import accumulate
from random import Random

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.archive import Archive
from pytest_hricdv.extra.closing.choice_statistics import ChoiceStatistics
from pytest_hricdv.extra.closing.interactions import Planned
from pytest_hricdv.extra.closing.strategy import Proposal
from pytest_hricdv.generate.abstract import AbstractDraft
from pytest_hricdv.generate.beliefs import START
from pytest_hricdv.generate.rng import pick
from pytest_hricdv.online.chooser import ANY_INTERACTION, ANY_STATE, DISTURBANCE, GOAL, NONE, Choice, Weight
from pytest_hricdv.online.role import Role

NAME = "online"

TARGETS = 4
"""A run has so many targets, one for each interaction. Chosen: a run of the table has at most four interactions; its
effect was not measured. What the whole way brings is in docs/closure.md: at ten seeds, nothing beyond chance."""

ALIKE = 3.0
"""How much likelier a further target is for each coordinate that it has in common with the first one. Chosen; its
effect was not measured."""

NEAREST = 2.0
"""How much likelier is what was chosen in the run that came nearest to the target. Chosen; its effect was not
measured."""

SURPRISES = (0.0, 1.0, 3.0)
"""How often somebody has an idea of their own in a run, and how often something goes wrong; one of these a run. Chosen:
a third of the runs each without any, with one and with several; their effect was not measured."""

LIKELIEST = 0.25
"""Neither is likelier than this between two commands. Chosen: a short run still has commands without any; its effect
was not measured."""

COMMANDS = 10
"""How long a run is as long as there is none to know it from. Chosen: it holds until the first run has ended; its
effect was not measured."""

TRIED_OFTEN = 8.0
"""After so many times, an option is less likely by a factor of the square root of two. Chosen; its effect was not
measured."""


class OnlineStrategy:
    """See the module.

    Args:
        roles: of those who decide.
        planned: `planned` of each cross product that has it.
    """

    name = NAME

    def __init__(self, roles: Sequence[Role], planned: Mapping[str, Planned]) -> None:
        goals = tuple(dict.fromkeys(goal for role in roles for goal in role.goals))
        groups = {name: (NONE, *group) for name, group in roles[0].space.groups.items()}
        self._options: Mapping[str, Sequence[str]] = {START: roles[0].space.start, **groups}
        self._rare: Mapping[str, Sequence[str]] = {GOAL: goals, DISTURBANCE: roles[0].disturbances}
        self._title = f"{'people who decide' if len(roles) > 1 else 'a person who decides'} during the run"
        self._statistics = ChoiceStatistics(planned)
        self._learned = 0

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Strategy`."""
        for entry in archive.entries[self._learned :]:
            self._statistics.learn(entry)
        self._learned = len(archive.entries)
        return [self._proposal(archive, rng) for _ in range(count)] if archive.open else []

    def _proposal(self, archive: Archive, rng: Random) -> Proposal:
        targets = _drawn(archive, rng)
        lengths = [len(entry.test.lines) for entry in archive.entries] or [COMMANDS]
        commands = max(sum(lengths) / len(lengths), 1.0)
        surprises = {about: min(pick(rng, SURPRISES) / commands, LIKELIEST) for about in self._rare}
        weights = (weight for place in self._places(targets) for weight in self._weights(archive, *place, surprises))
        return Proposal(AbstractDraft(NAME, (), (), name=self._title), NAME, targets, tuple(weights))

    def _places(self, targets: Sequence[Point]) -> Iterator[tuple[str, int, str, Sequence[Point]]]:
        """States, interactions, what is decided there, and the targets then: before the first one, its target."""
        anywhere = [(ANY_STATE, about) for about in (*self._options, *self._rare)]
        for state, about in dict.fromkeys([*anywhere, *self._statistics.places]):
            for interaction in range(len(targets) + 1):
                yield state, interaction, about, targets[max(interaction - 1, 0) :][:1]
        yield from ((state, ANY_INTERACTION, about, targets) for state, about in anywhere)

    def _weights(
        self,
        archive: Archive,
        state: str,
        interaction: int,
        about: str,
        targets: Sequence[Point],
        surprises: Mapping[str, float],
    ) -> Iterator[Weight]:
        rare = about in self._rare
        options = self._rare[about] if rare else self._options.get(about, ())  # acts are as the agent has them
        worths = {option: self._worth(archive, (state, about, option), targets) for option in options}
        if rare:
            yield state, interaction, about, NONE, 1.0 - surprises[about]
            scale = surprises[about] / sum(worths.values()) if worths else 0.0
            worths = {option: worth * scale for option, worth in worths.items()}
        yield from ((state, interaction, about, option, worth) for option, worth in worths.items())

    def _worth(self, archive: Archive, option: tuple[str, str, str], targets: Sequence[Point]) -> float:
        """How much likelier the targets are with an option, the less it was tried the more."""
        lifts = [self._statistics.lift(option, target) * _nearness(archive, option, target) for target in targets]
        mean = sum(lifts) / len(lifts) if lifts else 1.0
        return mean / math.sqrt(1.0 + self._statistics.times(option) / TRIED_OFTEN)


def _nearness(archive: Archive, option: tuple[str, str, str], target: Point) -> float:
    """More than 1 for what was chosen in the run that came nearest to a target."""
    if target not in archive.nearest:
        return 1.0
    chosen: Sequence[Choice] = archive.nearest[target][1].observation.choices
    return NEAREST if any((choice.about, choice.option) == option[1:] for choice in chosen) else 1.0


def _drawn(archive: Archive, rng: Random) -> tuple[Point, ...]:
    """Open points that runs can be nearer to or farther from; those likelier that fewer runs had as targets.

    The further ones are likely to be like the first one, so that one run can hit them all.
    """
    left = {
        point: 1.0 / (1 + archive.tries[point])
        for point in archive.open
        if point[0] == "bin" or point in archive.nearest
    }
    targets: list[Point] = []
    while left and len(targets) < TARGETS:
        points, upto = [*left], [*accumulate(left.values())]
        targets.append(points[min(bisect_right(upto, rng.random() * upto[-1]), len(points) - 1)])
        del left[targets[-1]]
        if len(targets) == 1:
            left = {point: weight * ALIKE ** _same(point, targets[0]) for point, weight in left.items()}
    return tuple(targets)


def _same(point: Point, other: Point) -> int:
    """How many coordinates two bins of a cross product have in common."""
    if point[0] != "bin" or point[:2] != other[:2]:
        return 0
    return sum(left == right for left, right in zip(point[2:], other[2:], strict=True))
