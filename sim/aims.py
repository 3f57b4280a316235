"""What a person aims at with each leg asked for, read off a script."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

Aim = tuple[str, str, str]
SENSES = ("gaze", "pressure", "location")
MOST_LEGS = 4


def aims(commands: Sequence[str]) -> tuple[Aim, ...]:
    """For each request: how many legs are asked for all told, "bored" or "not_bored", and the pose.

    A leg that is given up for boredom is asked for again and counts once; a table has four legs. The pose is gaze,
    pressure and location, as in "101", or "none" for a person who does not say ready.
    """
    asked = [place for place, command in enumerate(commands) if command == "tell leg"]
    turns = [commands[begin:end] for begin, end in pairwise([*asked, len(commands)])]
    legs = str(min(max(sum("bored" not in turn for turn in turns), 1), MOST_LEGS))
    return tuple((legs, "bored" if "bored" in turn else "not_bored", _pose(turn)) for turn in turns)


def _pose(turn: Sequence[str]) -> str:
    if "tell humanReady" not in turn:
        return "none"
    given = dict(command.removeprefix("set_param ").split(" = ") for command in turn if " = " in command)
    return "".join(given.get(sense, "0") for sense in SENSES)
