"""What people, doors and sensors tell the porter, and what it tells them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Phase(Enum):
    """What the porter is doing."""

    PARKED = "parked"
    LOADING = "loading"
    DRIVING = "driving"
    BLOCKED = "blocked"
    WAITING = "waiting"
    UNLOADING = "unloading"
    RETURNING = "returning"


@dataclass(frozen=True)
class Request:
    """A button of the porter's screen."""

    kind: str
    room: int = 0


@dataclass(frozen=True)
class Pin:
    """Four digits, typed in at the room."""

    digits: str


@dataclass(frozen=True)
class Lid:
    """The lid of the box was opened or closed."""

    closed: bool


@dataclass(frozen=True)
class Obstacle:
    """What the front sensor sees."""

    distance_m: float


@dataclass(frozen=True)
class Status:
    """Sent at each change of the phase."""

    phase: str
    room: int


@dataclass(frozen=True)
class Spoken:
    """A sentence of the loudspeaker."""

    text: str
