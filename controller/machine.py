"""The handover state machine: thirteen states, and the table of what follows what."""

from __future__ import annotations

from collections.abc import Callable

from controller.deciding import decide, sensing, timeout3, wait0
from controller.fetching import move_hand, reset
from controller.finishing import discard, release
from controller.ports import State
from controller.receiving import receive1, receive2, send1, timeout1, timeout2
from controller.robot import Robot

StateFunction = Callable[[Robot], str]

STATES: dict[str, StateFunction] = {
    "Reset": reset,
    "Receive1": receive1,
    "Timeout1": timeout1,
    "Move_hand": move_hand,
    "Send1": send1,
    "Receive2": receive2,
    "Timeout2": timeout2,
    "Wait0": wait0,
    "Sensing": sensing,
    "Timeout3": timeout3,
    "Decide": decide,
    "Release": release,
    "Discard": discard,
}

DONE = "Done"

TRANSITIONS: dict[tuple[str, str], str] = {
    ("Reset", "at home"): "Receive1",
    ("Reset", "stuck"): DONE,
    ("Receive1", "request"): "Move_hand",
    ("Receive1", "timeout"): "Timeout1",
    ("Timeout1", "wait on"): "Receive1",
    ("Move_hand", "offered"): "Send1",
    ("Move_hand", "no leg"): "Discard",
    ("Send1", "told"): "Receive2",
    ("Receive2", "ready"): "Wait0",
    ("Receive2", "timeout"): "Timeout2",
    ("Timeout2", "give up"): "Discard",
    ("Wait0", "settled"): "Sensing",
    ("Sensing", "sensed"): "Decide",
    ("Sensing", "timeout"): "Timeout3",
    ("Timeout3", "give up"): "Discard",
    ("Decide", "ready"): "Release",
    ("Decide", "not ready"): "Discard",
    ("Release", "next leg"): "Receive1",
    ("Release", "table done"): DONE,
    ("Discard", "next leg"): "Receive1",
    ("Discard", "table done"): DONE,
}


def run(robot: Robot) -> None:
    """Run the machine from Reset to the end of the table, reporting every state on the bus."""
    name = "Reset"
    while name != DONE:
        robot.bus.publish(State(name))
        outcome = STATES[name](robot)
        name = TRANSITIONS[name, outcome]
