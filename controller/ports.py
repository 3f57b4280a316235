"""What the controller is handed: messages it sends and hears, a clock, an arm and a hand.

Nothing here says how they are made: in a test they are ports of a simulated world, on the robot they are drivers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

M = TypeVar("M")
M_co = TypeVar("M_co", covariant=True)

ARM_JOINTS = (
    "hip_rotor",
    "hip_flexor",
    "left_shoulder_flex",
    "left_shoulder_abduction",
    "left_humeral_rot",
    "left_elbow_flex",
    "left_wrist_pronation",
    "left_wrist_abduction",
    "left_wrist_flex",
)
"""The order of the nine joint angles (rad) of a `JointPose`."""

JointPose = tuple[float, ...]


@dataclass(frozen=True)
class Request:
    """Heard from the person: "give me a leg"."""


@dataclass(frozen=True)
class LegReady:
    """Said by the robot: the leg of this turn (1 to 4) is held out."""

    turn: int


@dataclass(frozen=True)
class HumanReady:
    """Heard from the person: "I am ready"."""


@dataclass(frozen=True)
class Reading:
    """One reading of the three classified sensors; True means that the person is ready."""

    gaze: bool
    pressure: bool
    location: bool


@dataclass(frozen=True)
class State:
    """Reported by the robot: the state of its machine that it enters."""

    name: str


@dataclass(frozen=True)
class TurnDone:
    """Said by the robot: this turn is over; `outcome` is one of journal.OUTCOMES."""

    turn: int
    outcome: str


@dataclass(frozen=True)
class TableDone:
    """Said by the robot after the last turn: legs handed over, seconds it took, was a good table on time."""

    released: int
    duration_s: float
    on_time: bool


MESSAGES = (Request, LegReady, HumanReady, Reading, State, TurnDone, TableDone)


class PlanningError(Exception):
    """The arm knows no safe way to a pose."""


class Subscription(Protocol[M_co]):
    """A queue of messages of one kind."""

    def poll(self) -> M_co | None: ...

    def wait(self, timeout_s: float) -> M_co | None: ...

    def clear(self) -> None: ...

    def close(self) -> None: ...


class Bus(Protocol):
    """Sends and hears messages."""

    def publish(self, message: object) -> None: ...

    def subscribe(self, kind: type[M]) -> Subscription[M]: ...


class Clock(Protocol):
    """The time, in seconds."""

    def now_s(self) -> float: ...

    def sleep(self, duration_s: float) -> None: ...


class Path(Protocol):
    """A planned way of the arm."""

    @property
    def duration_s(self) -> float: ...


class Arm(Protocol):
    """Nine joints in the order of ARM_JOINTS."""

    def plan(self, waypoints: Sequence[JointPose], max_speed_rad_s: float) -> Path:
        """A way from where the arm is now through all `waypoints` (rad). Raises PlanningError."""

    def follow(self, path: Path) -> bool:
        """Move along `path`; blocks until the arm stands; True when it stands at the end of the path."""


class Hand(Protocol):
    """A hand of five fingers."""

    def close(self) -> bool:
        """Close the fingers; blocks until they stand; True when something is held."""

    def open(self) -> bool:
        """Open the fingers; blocks until they stand; True when they are seen to be open."""

    def holds(self) -> bool:
        """True while something is held."""
