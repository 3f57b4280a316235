"""The way of the person who lives in the run: the agent of the model decides from what happens there.

What it decides is drawn by weights: what has led near to the points aimed at is likelier, and what was seldom chosen.
What was chosen, and in which context, the runs of this way tell themselves.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from random import Random

from pytest_hricdv.close.archive import Archive, Entry
from pytest_hricdv.close.interactions import Planned, begins
from pytest_hricdv.close.way import Proposal
from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.disturbance import PREFIX
from pytest_hricdv.generate.abstract import Draft
from pytest_hricdv.generate.beliefs import START
from pytest_hricdv.generate.rng import pick
from pytest_hricdv.online.chooser import DISTURBANCE, GOAL, NONE, Weight
from pytest_hricdv.online.role import Role

NAME = "online"

AIMS = 4
"""So many open points a run is aimed at: about as many as it has interactions."""

SURPRISES = (0.0, 1.0, 3.0)
"""How often somebody has an idea of their own in a run, and how often something goes wrong; one of these a run."""

LIKELIEST = 0.5
"""Neither is likelier than this between two commands."""

ATTRACTION = 8.0
"""How much likelier what leads right to a point is than what does not lead there."""

Key = tuple[str, str, str]
"""Context, what was decided, and the option."""


@dataclass
class _Tried:
    """What is known of an option: how often it was chosen, and the points that came of it, with how often."""

    times: int = 0
    points: dict[Point, int] = field(default_factory=dict)


class OnlineWay:
    """See the module.

    Args:
        role: of the person.
        planned: `planned` of each cross product that has it.
    """

    name = NAME

    def __init__(self, role: Role, planned: Mapping[str, Planned]) -> None:
        groups = {name: (NONE, *group) for name, group in role.space.groups.items()}
        rare = {GOAL: role.goals, DISTURBANCE: role.disturbances}
        self._options: Mapping[str, Sequence[str]] = {START: role.space.start, **groups, **rare}
        self._planned = dict(planned)
        self._tried: dict[Key, _Tried] = {}
        self._learned = 0

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Way`."""
        for entry in archive.entries[self._learned :]:
            self._learn(entry)
        self._learned = len(archive.entries)
        return [self._proposal(archive, rng) for _ in range(count)] if archive.open else []

    def _proposal(self, archive: Archive, rng: Random) -> Proposal:
        aims = _drawn(archive, rng)
        commands = sum(len(entry.test.lines) for entry in archive.entries) / max(len(archive.entries), 1)
        surprise = min(pick(rng, SURPRISES) / max(commands, 1.0), LIKELIEST)
        draft = Draft(NAME, (), (), name="a person who decides during the run")
        return Proposal(draft, NAME, aims, tuple(self._weights(archive, aims, surprise)))

    # --- what has come of choices

    def _learn(self, entry: Entry) -> None:
        """Note what came of each choice of a run: what its interaction hit, or, without interactions, the run."""
        hits, lines = entry.observation.hits, entry.test.lines
        commands = [line for line in lines if not line.startswith(PREFIX)]
        first = {product: begins(commands, planned) for product, planned in self._planned.items()}
        for choice in entry.observation.choices:
            done = sum(not line.startswith(PREFIX) for line in lines[: choice.taken])
            points: list[Point] = []
            for product, starts in first.items():
                number = max(bisect_right(starts, done) - 1, 0)
                points += (("bin", product, *each) for each in hits.get(product, ())[number : number + 1])
            for context in dict.fromkeys((choice.context, "")):
                tried = self._tried.setdefault((context, choice.about, choice.option), _Tried())
                tried.times += 1
                for point in points or entry.observation.points:
                    tried.points[point] = tried.points.get(point, 0) + 1

    # --- weights

    def _weights(self, archive: Archive, aims: Sequence[Point], surprise: float) -> Iterator[Weight]:
        """Of all options in any context, and in the contexts in which they were chosen before."""
        near = {point for aim in aims if aim in archive.nearest for point in archive.nearest[aim][1].observation.points}
        places = dict.fromkeys([*(("", about) for about in self._options), *((key[0], key[1]) for key in self._tried)])
        for context, about in places:
            options = self._options.get(about, ())  # of acts, only those that it is ready for can be chosen
            worths = {option: self._worth((context, about, option), aims, near) for option in options}
            if about in (GOAL, DISTURBANCE):
                yield context, about, NONE, 1.0 - surprise
                scale = surprise / sum(worths.values()) if worths else 0.0
                worths = {option: worth * scale for option, worth in worths.items()}
            yield from ((context, about, option, worth) for option, worth in worths.items())

    def _worth(self, key: Key, aims: Sequence[Point], near: set[Point]) -> float:
        """How much is expected of an option: the more, the nearer it led to the aims, and the less it was tried."""
        tried = self._tried.get(key)
        if tried is None:
            return 1.0 + ATTRACTION / 2.0
        total = sum(tried.points.values())
        led = sum(_likeness(point, aim) * times for point, times in tried.points.items() for aim in aims)
        led += sum(times for point, times in tried.points.items() if point in near)
        return (1.0 + ATTRACTION * led / max(total, 1)) / math.sqrt(1.0 + tried.times / 4.0)


def _likeness(point: Point, aim: Point) -> float:
    """How near a point is to another: 1 if it is the same, half as much with each coordinate of a bin that differs."""
    if point == aim:
        return 1.0
    if point[0] != "bin" or point[:2] != aim[:2] or len(point) != len(aim):
        return 0.0
    return 0.5 ** sum(one != other for one, other in zip(point[2:], aim[2:], strict=True))


def _drawn(archive: Archive, rng: Random) -> tuple[Point, ...]:
    """Open points that runs can be nearer to or farther from; those likelier at which fewer runs were aimed."""
    left = [point for point in archive.open if point[0] == "bin" or point in archive.nearest]
    found: list[Point] = []
    while left and len(found) < AIMS:
        upto = [*accumulate(1.0 / (1 + archive.tries[point]) for point in left)]
        found.append(left.pop(min(bisect_right(upto, rng.random() * upto[-1]), len(left) - 1)))
    return tuple(found)
