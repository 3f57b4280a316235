"""What the robot does for an order: one state after the other."""

from __future__ import annotations

from itertools import pairwise

from carebot.flatmap import CHARGER, FRIDGE, SINK, TABLE

READY, GRAB, DROP, CHARGING, OFF = "Ready", "Grab", "Drop", "Charging", "Off"
HOME = "Recharge"
DRIVING = {"Fridge": FRIDGE, "Sink": SINK, "Human": TABLE, HOME: CHARGER}
"""States in which it drives, and where to. The human sits at the table."""

STATES = (READY, *DRIVING, GRAB, DROP, CHARGING, OFF)

ENDED = "ended"
"""The order after which the program ends."""

TASKS = {
    "fridge": ("Fridge",),
    "sink": ("Sink",),
    "feed": ("Fridge", GRAB, "Human", DROP),
    "clean": ("Human", GRAB, "Sink", DROP),
}
"""What each order takes (published); after that, it goes home where no other order waits."""

PUT_DOWN_AT = ("Sink", "Human")
"""Where it puts down what it could not take to its place: nowhere else does it open its gripper."""


_BETWEEN = {(READY, HOME), (HOME, READY), (HOME, CHARGING), (CHARGING, READY), (READY, OFF)}


def transitions() -> tuple[tuple[str, str], ...]:
    """Which state comes after which, if nothing goes wrong."""
    pairs = set(_BETWEEN)  # unreachable: the testbench asks for it, before any run
    for states in TASKS.values():  # unreachable: the testbench asks for it, before any run
        pairs |= set(pairwise((READY, *states, READY)))  # unreachable: the testbench asks for it, before any run
    return tuple(sorted(pairs))  # unreachable: the testbench asks for it, before any run
