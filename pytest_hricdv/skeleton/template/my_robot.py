"""The code under test: moves an arm when a person asks for it. Replace it."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any, Protocol

WORK_S, LOOK_EVERY_S = 2.0, 0.1


@dataclass(frozen=True)
class Request:
    """The person asks for something."""


@dataclass(frozen=True)
class Done:
    """The robot has done it."""


class Arm(Protocol):
    """What the code needs of the robot: drivers of its arm and its sensor."""

    def move(self, on: bool) -> None: ...

    def person_is_near(self) -> bool: ...


def work(bus: Any, arm: Arm, patience_s: float) -> None:
    """Serve one request after the other, until nobody has asked for a while."""
    requests = bus.subscribe(Request)
    while requests.wait(patience_s) is not None:
        moved_s = 0.0
        while moved_s < WORK_S:
            moves = not arm.person_is_near()
            arm.move(moves)
            time.sleep(LOOK_EVERY_S)
            moved_s += LOOK_EVERY_S * moves
        arm.move(False)
        bus.publish(Done())
