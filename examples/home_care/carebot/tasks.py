"""What the robot does for an order: one state after the other."""

from __future__ import annotations

from carebot.flatmap import CHARGER, FRIDGE, SINK, TABLE

READY, GRAB, DROP, CHARGING = "Ready", "Grab", "Drop", "Charging"
DRIVING = {"Fridge": FRIDGE, "Sink": SINK, "Human": TABLE, "Recharge": CHARGER}
"""States in which it drives, and where to. The human sits at the table."""

STATES = (READY, *DRIVING, GRAB, DROP, CHARGING)

ENDED = "ended"
"""The order after which the program ends."""

TASKS = {
    "fridge": ("Fridge", "Recharge"),
    "sink": ("Sink", "Recharge"),
    "feed": ("Fridge", GRAB, "Human", DROP, "Recharge"),
    "clean": ("Human", GRAB, "Sink", DROP, "Recharge"),
}
"""What each order takes (published)."""

PUT_DOWN_AT = ("Sink", "Human")
"""Where it puts down what it could not take to its place: nowhere else does it open its gripper."""


def transitions() -> tuple[tuple[str, str], ...]:
    """Which state comes after which, if nothing goes wrong."""
    pairs = {(READY, "Recharge"), ("Recharge", READY), ("Recharge", CHARGING), (CHARGING, READY)}
    for states in TASKS.values():
        pairs |= set(zip((READY, *states), states, strict=False))
    return tuple(sorted(pairs))
