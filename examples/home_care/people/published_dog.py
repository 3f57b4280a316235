"""The dog of the published case, as far as its facts are known: it is *set* somewhere else five times a second.

It walks straight for a while, then in another direction, within its area, whoever is in its way: so it may be set into
the robot. Where its way would leave its area, and come near to the robot, it jumps: to wherever that is. What comes of
it is shown by a study; else no test has this dog.
"""

from __future__ import annotations

import math
from random import Random

from house.flat import DOG_AREA
from house.house import House

from pytest_hricdv.testbench import Run

PERIOD_S = 0.2
STEP_M = 0.1
"""At most, in x and in y."""

STEPS = 15
"""In one direction."""

NEAR_M = 0.55
"""To the robot, from middle to middle."""

JUMP_M = 1.0
"""At most, in x and in y."""

TRIES = 20
"""To find a step that stays in the area (chosen); without one it stays where it is."""


class PublishedDog:
    """The published dog of a run. Its walk depends on the test's seed, and on where the robot is."""

    def __init__(self, run: Run, house: House) -> None:
        self._run, self._house = run, house
        self._random = Random(f"{run.test.seed} dog")

    def live(self) -> None:
        """Walk for ever; the body of its node."""
        while True:
            step = self._draw(STEP_M)
            for _ in range(STEPS):
                step = self._allowed(step)
                self._house.dog_jumps(*step)
                self._run.kernel.sleep(PERIOD_S)

    def _draw(self, most_m: float) -> tuple[float, float]:
        return self._random.uniform(-most_m, most_m), self._random.uniform(-most_m, most_m)

    def _allowed(self, step: tuple[float, float]) -> tuple[float, float]:
        """This step, or another one in its place."""
        for _ in range(TRIES):
            (x, y), robot = self._house.dog.at, self._house.base.at
            to = x + step[0], y + step[1]
            leaves, near = not DOG_AREA.contains(to), math.dist(to, robot) < NEAR_M
            if leaves and near:
                return self._draw(JUMP_M)
            if not leaves:
                return step
            step = self._draw(STEP_M)
        return 0.0, 0.0
