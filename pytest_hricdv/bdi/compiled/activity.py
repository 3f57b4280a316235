"""What compiled agents are busy with."""

from __future__ import annotations

from pytest_hricdv.bdi.language.terms import Term

from .program import Annots, PlanCode, TriggerCode, Values

Args = tuple[Term, ...]
Goal = tuple[TriggerCode, Args, Annots]
"""What an event is about: a goal, or a belief that has come or gone."""
Caller = tuple[PlanCode, int, Values, Goal]


class Activity:
    """What an intention is to the interpreter: the plan being executed, and those that called it.

    Args:
        number: its number among those of the agent, from 1.
        plan: the plan to be executed.
        values: what its variables stand for.
        goal: what it was selected for.
    """

    __slots__ = ("below", "goal", "left", "number", "open", "pc", "plan", "values")

    def __init__(self, number: int, plan: PlanCode, values: Values, goal: Goal) -> None:
        self.number = number
        self.plan = plan
        self.values = values
        self.goal = goal
        self.pc = 0
        """The number of its statement to be executed, or of the one waited for."""
        self.below: list[Caller] = []
        """The plans that wait for it, the outermost first."""
        self.open = 0
        """How many of those have statements left."""
        self.left = 0
        """The cycles left, as far as known, when it came to something to be left to the interpreter."""


Pending = tuple[Goal, Activity | None]
"""An event, and the activity that waits for it."""


def begin(activity: Activity, goal: Goal, plan: PlanCode, values: Values) -> None:
    """Execute a plan next; the one being executed waits for it, unless it ends by pursuing its own goal again."""
    caller, pc = activity.plan, activity.pc
    if caller.after[pc] != caller.end:
        activity.below.append((caller, pc, activity.values, activity.goal))
        activity.open += 1
    elif not caller.forgotten and (pc != caller.last or goal[0] is not activity.goal[0] or not goal[0].is_goal):
        activity.below.append((caller, pc, activity.values, activity.goal))
    activity.plan, activity.values, activity.goal, activity.pc = plan, values, goal, 0


def resumed(activity: Activity) -> bool:
    """Go on after the statement that an activity has waited for; False if that was the last of all its plans."""
    plan = activity.plan
    activity.pc = plan.after[activity.pc]
    return activity.pc != plan.end or returned(activity)


def returned(activity: Activity) -> bool:
    """Go back from a finished plan to where it was called; False if the activity has ended."""
    if not activity.open:
        return False
    while True:
        plan, pc, activity.values, activity.goal = activity.below.pop()
        if plan.after[pc] != plan.end:
            activity.open -= 1
            activity.plan, activity.pc = plan, plan.after[pc]
            return True
