"""What compiled agents are busy with."""

from __future__ import annotations

from typing import Any

from ..terms import Term
from .program import Annots, PlanCode, TriggerCode, Values

Args = tuple[Term, ...]
Goal = tuple[TriggerCode, Args, Annots]
"""What an event is about: a goal, or a belief that has come or gone."""
Slot = Any
"""A proposition's name, or a belief's arguments."""
Store = dict[Slot, Annots]
"""Beliefs by their slots, with their annotations, the oldest first."""
Caller = tuple[PlanCode, int, Values, Goal]


class Activity:
    """What an intention is to the interpreter: the plan being executed, and those that called it.

    Args:
        number: its number among those of the agent, from 1.
    """

    __slots__ = ("below", "goal", "left", "number", "pc", "plan", "values")

    def __init__(self, number: int) -> None:
        self.number = number
        self.plan: PlanCode
        """The plan being executed."""
        self.goal: Goal
        """What it was selected for."""
        self.pc = 0
        """The number of its statement to be executed, or of the one waited for."""
        self.values: Values = ()
        """What its variables stand for."""
        self.below: list[Caller] = []
        """The plans that wait for it, the outermost first."""
        self.left = 0
        """The cycles left, as far as known, when it came to something to be left to the interpreter."""


Pending = tuple[Goal, Activity | None]
"""An event, and the activity that waits for it."""


def resumed(activity: Activity) -> bool:
    """Go on after the statement that an activity has waited for; False if that was the last of all its plans."""
    plan = activity.plan
    activity.pc = plan.after[activity.pc]
    return activity.pc != plan.end or returned(activity)


def returned(activity: Activity) -> bool:
    """Go back from a finished plan to where it was called; False if the activity has ended."""
    below = activity.below
    while below:
        plan, pc, activity.values, activity.goal = below.pop()
        activity.plan = plan
        activity.pc = plan.after[pc]
        if activity.pc != plan.end:
            return True
    return False
