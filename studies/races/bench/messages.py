"""The messages of the person and of the robots."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Go:
    """The person asks for something."""


@dataclass(frozen=True)
class Stop:
    """The person stops the robot."""


@dataclass(frozen=True)
class Done:
    """The robot has done what was asked for."""
