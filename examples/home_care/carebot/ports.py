"""What the robot's code is handed: its base with laser and localization, its gripper, and its battery."""

from __future__ import annotations

from typing import Protocol

from carebot.messages import GripperCommand, GripperState, Pose, Scan, Velocity


class Base(Protocol):
    """The mobile base; reading it takes no time, and motors keep what they were told last."""

    def pose(self) -> Pose:
        """Where it is now."""

    def scan(self) -> Scan:
        """What its laser sees now."""

    def drive(self, velocity: Velocity) -> None:
        """Go on with this velocity."""


class Gripper(Protocol):
    """The gripper at the arm's end; opening and closing take a few seconds."""

    def command(self, command: GripperCommand) -> None:
        """Begin to close or to open."""

    def state(self) -> GripperState:
        """How far it is open now."""


class Battery(Protocol):
    """The battery."""

    def level(self) -> float:
        """How full it is now, 0 to 1; it is charged while the robot stands at its charger."""
