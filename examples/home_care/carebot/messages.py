"""What the robot hears and says, and what its sensors and motors are told: one frozen dataclass each."""

from __future__ import annotations

from dataclasses import dataclass

# --- to the robot


@dataclass(frozen=True)
class Order:
    """What the person wants.

    Args:
        kind: "fridge", "sink", "feed" or "clean"; "ended" for no more orders. The robot refuses any other one.
    """

    kind: str


@dataclass(frozen=True)
class Scan:
    """One turn of the laser.

    Args:
        ranges: distances in m, from -180 deg to 180 deg of the robot's heading in equal steps, the last one excluded:
            counter-clockwise, so that the middle one is straight ahead. Infinite where nothing is in reach.
    """

    ranges: tuple[float, ...]


@dataclass(frozen=True)
class Pose:
    """Where the robot is, as its localization says.

    Args:
        x: m, in the flat's frame.
        y: m.
        heading: rad, counter-clockwise from the x axis, in -pi..pi.
    """

    x: float
    y: float
    heading: float


@dataclass(frozen=True)
class GripperState:
    """How far the gripper is open: 0 closed, 1 wide open."""

    opening: float


# --- from the robot


@dataclass(frozen=True)
class Velocity:
    """What the base is to do from now on: `forward` in m/s, `turn` in rad/s, counter-clockwise."""

    forward: float
    turn: float


@dataclass(frozen=True)
class GripperCommand:
    """Close the gripper, or open it."""

    close: bool


@dataclass(frozen=True)
class State:
    """What the robot is doing: a name of `carebot.tasks.STATES`."""

    name: str


@dataclass(frozen=True)
class Accepted:
    """The robot will do what was ordered."""

    order: str


@dataclass(frozen=True)
class Refused:
    """The robot will not do it, or has given it up, and why."""

    order: str
    reason: str


@dataclass(frozen=True)
class Completed:
    """What was ordered is done."""

    order: str


@dataclass(frozen=True)
class Idle:
    """Nobody has ordered anything for a while: the robot goes to its charger."""


@dataclass(frozen=True)
class Docked:
    """The robot is at its charger."""


@dataclass(frozen=True)
class Food:
    """Whether the robot holds food, or dishes, in its gripper."""

    held: bool


HEARD = (Order,)
"""What comes to the robot on its bus; scans and poses are read at its ports."""

SAID = (State, Accepted, Refused, Completed, Idle, Docked, Food)
"""What the robot says on its bus; velocities and commands of the gripper go to its ports."""
