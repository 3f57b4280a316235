"""The turns of a run, one for each requested leg: as its script plans them, and as its messages record them."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Sequence
from itertools import pairwise

from controller.ports import Reading, State, TurnDone
from pytest_hricdv.runtime import RecordedMessage, topic_of

PlannedTurn = tuple[str, str, str]
SENSORS = ("gaze", "pressure", "location")
MAX_LEGS = 4
TURN_STATE = "Move_hand"
"""The robot enters this state when it begins a turn."""


def planned_turns(commands: Sequence[str]) -> tuple[PlannedTurn, ...]:
    """For each request: the number of legs requested in the whole script, "bored" or "not_bored", and the pose.

    A bored person requests the same leg again, which counts once; a table has four legs. The pose is gaze, pressure and
    location, as in "101", or "none" for a person who does not say ready.
    """
    requests = [index for index, command in enumerate(commands) if command == "tell leg"]
    turns = [commands[begin:end] for begin, end in pairwise([*requests, len(commands)])]
    legs = str(min(max(sum("bored" not in turn for turn in turns), 1), MAX_LEGS))
    return tuple((legs, "bored" if "bored" in turn else "not_bored", _pose(turn)) for turn in turns)


def ended_turns(
    commands: Sequence[str], action_times_s: Sequence[float], messages: Iterable[RecordedMessage]
) -> tuple[tuple[PlannedTurn, str], ...]:
    """Each planned turn that the robot took up, with its outcome.

    A request that the robot does not hear, or hears while it is at work, opens no turn; one out of turn may open one.
    So a turn of the robot belongs to the request at which the person was when it began; of several, the first does.

    Args:
        commands: of the script.
        action_times_s: when each of them began (s), as far as they did.
        messages: of the run.
    """
    asked_s = [time_s for command, time_s in zip(commands, action_times_s, strict=False) if command == "tell leg"]
    outcomes: dict[int, str] = {}
    request = 0
    for message in messages:
        if message.topic == topic_of(State) and message.fields["name"] == TURN_STATE:
            request = bisect_right(asked_s, message.time_s)
        elif message.topic == topic_of(TurnDone) and request:
            outcomes.setdefault(request - 1, str(message.fields["outcome"]))
    planned = planned_turns(commands)
    return tuple((planned[number], outcome) for number, outcome in sorted(outcomes.items()))


def _pose(turn: Sequence[str]) -> str:
    if "tell humanReady" not in turn:
        return "none"
    pose = dict(command.removeprefix("set_param ").split(" = ") for command in turn if " = " in command)
    return "".join(pose.get(sensor, "0") for sensor in SENSORS)


def observed_turns(messages: Iterable[RecordedMessage]) -> tuple[tuple[str, str], ...]:
    """For each turn: the sensor reading (gaze, pressure, location, as in "101"; "none" without one) and the outcome."""
    turns, reading = [], "none"
    for message in messages:
        if message.topic == topic_of(Reading):
            reading = "".join(str(int(bool(message.fields[name]))) for name in ("gaze", "pressure", "location"))
        elif message.topic == topic_of(TurnDone):
            turns.append((reading, str(message.fields["outcome"])))
            reading = "none"
    return tuple(turns)
