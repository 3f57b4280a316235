from __future__ import annotations

from enum import Enum, auto

from walker.events import EVENTS, BrakeCommand, ButtonPressed, Command, Event, GripChanged, ObstacleSeen, TiltMeasured

FALL_DEG = 25.0
NEAR_M = 0.6


class Mode(Enum):
    LOCKED = auto()
    STANDING = auto()
    WALKING = auto()
    SLOWING = auto()
    FALLEN = auto()


def brake(strength: float = 1.0) -> BrakeCommand:
    return {"action": "brake", "strength": strength}


class WalkerController:
    def __init__(self, *, max_tilt: float = FALL_DEG) -> None:
        self._mode = Mode.LOCKED
        self._max_tilt = max_tilt

    @property
    def mode(self) -> Mode:
        return self._mode

    def feed(self, line: str | bytes) -> list[Command]:
        return self.handle(EVENTS.validate_json(line))

    def handle(self, event: Event) -> list[Command]:
        match (self._mode, event):
            case (_, TiltMeasured(degrees=degrees)) if abs(degrees) > self._max_tilt:
                self._mode = Mode.FALLEN
                return [brake(), {"action": "alarm", "reason": "fall"}]
            case (_, ButtonPressed(button="sos")):
                return [{"action": "alarm", "reason": "sos"}]
            case (Mode.FALLEN, ButtonPressed(button="unlock")):
                self._mode = Mode.LOCKED
                return []
            case (Mode.FALLEN, _):
                return []
            case (Mode.LOCKED, ButtonPressed(button="unlock")):
                self._mode = Mode.STANDING
                return [brake(0.5)]
            case (_, ButtonPressed(button="lock")):
                self._mode = Mode.LOCKED
                return [brake()]
            case (Mode.STANDING, GripChanged(left=True, right=True)):
                self._mode = Mode.WALKING
                return [{"action": "release", "strength": 0.0}]
            case (Mode.WALKING | Mode.SLOWING, GripChanged(left=left, right=right)) if not (left and right):
                self._mode = Mode.STANDING
                return [brake(0.5)]
            case (Mode.WALKING, ObstacleSeen(distance_m=distance, kind=kind)) if distance < NEAR_M:
                self._mode = Mode.SLOWING
                return [{"action": "slow", "strength": 0.9 if kind == "person" else 0.6}]
            case (Mode.SLOWING, ObstacleSeen(distance_m=distance)) if distance >= NEAR_M:
                self._mode = Mode.WALKING
                return [{"action": "release", "strength": 0.0}]
            case _:
                return []
