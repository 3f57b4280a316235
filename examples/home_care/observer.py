"""What requirements need and the house does not record: samples as the published monitors took them, and open ways."""

from __future__ import annotations

import math

from carebot.flatmap import HULL_M, PLACES
from carebot.messages import State
from carebot.tasks import DRIVING
from house.house import House
from house.routes import Around, route
from house.walkers import DOG_RADIUS_M, PERSON_RADIUS_M

from pytest_hricdv.testbench import Run

SAMPLED_S = 1.0
"""Between two samples, as the published monitors say of themselves."""

STOOD_X_M, STOOD_Y_M, AWAY_M = 0.05, 0.1, 0.2
"""A4, as published."""

MARGIN_M = 0.05
"""A way is open where the robot has so much more room than it needs: between things (chosen),"""

ROOM_M = 0.5
"""and so much between it and the person or the dog (chosen: what the robot keeps away from them, and a bit more)."""

DOG_NEAR_M = 1.0
"""A dog that comes nearer to the robot's hull than this while it works has been met (chosen: the robot has seen it)."""

SIGNALS: dict[str, type[bool] | type[float]] = {
    "moved": float,
    "stood": bool,
    "away": bool,
    "acts": bool,
    "way_open": bool,
}
UNITS = {"moved": "m"}

REST_OF_RUN_S = 10_000.0


class Observer:
    """Takes a sample each second while anything moves or is to move, in a node of its own."""

    def __init__(self, run: Run, house: House) -> None:
        self._run, self._house = run, house
        self._states = run.bus.port("observer").subscribe(State)
        self._state = ""
        self._at = house.base.at
        self._recorded: dict[str, bool | float] = {}
        self.dog_met_s: list[float] = []
        """When the dog was near to the robot while that drove (s)."""
        self._sample()

    def watch(self) -> None:
        """The node's body."""
        while True:
            self._run.kernel.sleep(SAMPLED_S)
            self._sample()
            if not self._is_lively():
                self._house.wait(self._is_lively, REST_OF_RUN_S)
                # Woken at the end of the first step in which something moved: a period of samples begins here.
                self._at = self._house.base.at

    def _is_lively(self) -> bool:
        """Whether anything moves, or the robot says that it is about to."""
        while (state := self._states.poll()) is not None:
            self._state = state.name
        return self._state in DRIVING or not self._house.still

    def _sample(self) -> None:
        self._is_lively()
        base, before = self._house.base, self._at
        self._at = base.at
        dx, dy = abs(base.at[0] - before[0]), abs(base.at[1] - before[1])
        to_x, to_y = (abs(there - here) for there, here in zip(PLACES["charger"], base.at, strict=True))
        acts = not base.resting or self._house.gripper.moving
        if self._state in DRIVING and self._house.dog.gap_to(base.at, base.radius_m).width_m < DOG_NEAR_M:
            self.dog_met_s.append(self._run.kernel.now_s)
        self._record("moved", round(math.hypot(dx, dy), 4))
        self._record("stood", dx < STOOD_X_M and dy < STOOD_Y_M)
        self._record("away", to_x > AWAY_M and to_y > AWAY_M)
        self._record("acts", acts)
        self._record("way_open", acts or self._is_way_open())

    def _is_way_open(self) -> bool:
        """Whether there is a way to where the robot says that it drives; True where it does not drive."""
        place = DRIVING.get(self._state)
        if place is None:
            return True
        others = ((self._house.person, PERSON_RADIUS_M), (self._house.dog, DOG_RADIUS_M))
        around = (Around(who.at, HULL_M + radius_m + ROOM_M) for who, radius_m in others)
        return bool(route(self._house.base.at, PLACES[place], HULL_M + MARGIN_M, *around))

    def _record(self, name: str, value: bool | float) -> None:
        if self._recorded.get(name) != value:
            self._recorded[name] = value
            self._run.recorder.signal(self._run.kernel.now_s, name, value)
