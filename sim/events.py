"""What happens around the robot that it hears nothing of, as messages in the record: requirements can be told it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SupplyDisturbed:
    """From now on, until the robot holds one again, no leg has to wait at the pickup place."""


@dataclass(frozen=True)
class WayBlocked:
    """Somebody leans into the arm's way, or has gone again."""

    blocked: bool


@dataclass(frozen=True)
class FingersHeld:
    """Somebody begins to hold the robot's fingers shut, for longer than a handover takes."""


Event = SupplyDisturbed | WayBlocked | FingersHeld

EVENTS = (SupplyDisturbed, WayBlocked, FingersHeld)
