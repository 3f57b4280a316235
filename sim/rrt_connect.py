"""RRT-Connect: two trees of free poses, from start and goal, grow towards random poses and each other.

Kuffner and LaValle, "RRT-Connect: An efficient approach to single-query path planning", ICRA 2000.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from random import Random

Angles = tuple[float, ...]

STEP_RAD = 0.7
"""A tree grows by at most this distance at once."""


class NoChecksLeftError(Exception):
    """The search has used up its collision checks."""


class RrtConnect:
    """A search between two poses.

    Args:
        limits: least and largest angle of each joint (rad).
        is_free: whether a pose is free of collisions.
        sample_rad: largest joint angle between two collision checks.
        max_checks: after so many the search is given up.
        seed: of its random numbers.
    """

    def __init__(
        self,
        limits: Sequence[tuple[float, float]],
        is_free: Callable[[Angles], bool],
        sample_rad: float,
        max_checks: int,
        seed: int,
    ) -> None:
        self._limits = tuple(limits)
        self._is_free = is_free
        self._sample_rad = sample_rad
        self._left = max_checks
        self._random = Random(seed)

    def way(self, start: Angles, goal: Angles) -> tuple[Angles, ...] | None:
        """Poses between `start` and `goal`, joined by free straight ways; None where none were found."""
        way: tuple[Angles, ...] | None = None
        try:
            way = self._joined({start: None}, {goal: None})
            return self._shortened((start, *way, goal))
        except NoChecksLeftError:
            return way

    def _joined(self, growing: dict[Angles, Angles | None], other: dict[Angles, Angles | None]) -> tuple[Angles, ...]:
        """The poses between the roots of two trees (pose -> the one it was reached from)."""
        forwards = True
        while True:
            target = tuple(low + (high - low) * self._random.random() for low, high in self._limits)
            tip = self._grow(growing, target, steps=1)
            if tip is not None and self._grow(other, tip, steps=None) == tip:
                there, back = _branch(growing, tip), _branch(other, tip)
                way = (*reversed(there), *back[1:]) if forwards else (*reversed(back), *there[1:])
                return way[1:-1]
            growing, other, forwards = other, growing, not forwards

    def _grow(self, tree: dict[Angles, Angles | None], target: Angles, steps: int | None) -> Angles | None:
        """Grow a tree towards a pose, step by step until something is in the way; the last pose that was added."""
        here = min(tree, key=lambda pose: math.dist(pose, target))
        if here == target:
            return here
        tip = None
        while steps is None or steps > 0:
            way_rad = math.dist(here, target)
            share = min(1.0, STEP_RAD / way_rad)
            there = target if share == 1.0 else tuple(a + share * (b - a) for a, b in zip(here, target, strict=True))
            if not self._is_clear(here, there):
                break
            tree.setdefault(there, here)
            here = tip = there
            if there == target:
                break
            steps = None if steps is None else steps - 1
        return tip

    def _shortened(self, way: tuple[Angles, ...]) -> tuple[Angles, ...]:
        """The way without poses that are not needed, and without its ends."""
        kept = [way[0]]
        while kept[-1] != way[-1]:
            at = way.index(kept[-1])
            farthest_first = range(len(way) - 1, at + 1, -1)
            kept.append(next((way[to] for to in farthest_first if self._is_clear(way[at], way[to])), way[at + 1]))
        return tuple(kept[1:-1])

    def _is_clear(self, here: Angles, there: Angles) -> bool:
        """Whether the straight way to a pose is free; its start is."""
        checks = 1 + math.ceil(max(abs(b - a) for a, b in zip(here, there, strict=True)) / self._sample_rad)
        for check in range(1, checks + 1):
            self._left -= 1
            if self._left < 0:
                raise NoChecksLeftError
            if not self._is_free(tuple(a + check / checks * (b - a) for a, b in zip(here, there, strict=True))):
                return False
        return True


def _branch(tree: dict[Angles, Angles | None], pose: Angles) -> tuple[Angles, ...]:
    """From a pose to the root."""
    branch = [pose]
    while (before := tree[branch[-1]]) is not None:
        branch.append(before)
    return tuple(branch)
