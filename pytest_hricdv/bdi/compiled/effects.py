"""What statements of a compiled agent do besides changing its beliefs."""

from __future__ import annotations

from typing import TYPE_CHECKING, NoReturn

from pytest_hricdv.bdi.language.syntax import ExternalAction, Plan
from pytest_hricdv.bdi.language.terms import Structure

from ..intentions import Wait
from ..spinning import leave_alone
from .activity import Activity, Args, Goal, begin, returned
from .posting import hold
from .program import Annots, TriggerCode
from .runtime import BailError

if TYPE_CHECKING:
    from .agent import CompiledAgent


def enter(agent: CompiledAgent, activity: Activity, goal: Goal, left: int) -> int:
    """Post a belief event that an activity waits for and react to it at once, as nothing can come between.

    Returns:
        The cycles left.
    """
    trigger, args, annots = goal
    select = trigger.select
    try:
        selected = None if select is None else select(agent, agent.p, agent.tables, args, annots)
    except BailError:
        _refuse(agent, activity, activity.pc, goal, left)
    if selected is None:
        activity.pc = activity.plan.after[activity.pc]
    else:
        plan, values = selected
        agent.executed.append(plan.label)
        begin(activity, goal, plan, values)
    return left


def pursue(agent: CompiledAgent, activity: Activity, pc: int, goal: Goal, left: int) -> int:
    """Post a goal that an activity waits for; with a cycle left, select a plan and begin it.

    Returns:
        The cycles left.
    """
    if left == 1:
        return pause_at(agent, activity, pc, goal)
    trigger, args, annots = goal
    select = trigger.select
    selected = None if select is None else select(agent, agent.p, agent.tables, args, annots)
    if selected is None:
        _refuse(agent, activity, pc, goal, left - 1)
    plan, values = selected
    agent.executed.append(plan.label)
    activity.pc = pc
    begin(activity, goal, plan, values)
    return left - 1


def _refuse(agent: CompiledAgent, activity: Activity, pc: int, goal: Goal, left: int) -> NoReturn:
    """Leave to the interpreter which plan is for an event that an activity waits for."""
    activity.pc = pc
    activity.left = left
    agent.events.appendleft((goal, activity))
    raise BailError


def spin(agent: CompiledAgent, activity: Activity, goal: Goal, left: int) -> int:
    """Pursue a goal for which the plan does nothing but that.

    Returns:
        The cycles not needed, as a negative number: if there is nothing else to do, the agent is left alone.
    """
    activity.pc = 0
    agent.events.append((goal, activity))
    # What the plan looks for may have come after the plan was selected.
    is_new = agent.resumed is not activity or left < agent.granted
    if is_new and len(agent.events) == 1 and not (agent.intentions or agent.mailbox or agent.feedback):
        agent.look_up()
        leave_alone(agent, activity.plan.plan.label, agent.run.rounds + agent.granted - left + 1)
    return 1 - left


def pause(agent: CompiledAgent, activity: Activity, pc: int) -> int:
    """No cycle is left: go on at a statement in the next one."""
    activity.pc = pc
    agent.intentions.append(activity)
    return 0


def pause_at(agent: CompiledAgent, activity: Activity, pc: int, goal: Goal) -> int:
    """No cycle is left after an event was posted: wait for it."""
    activity.pc = pc
    agent.events.append((goal, activity))
    return 0


def pause_for(
    agent: CompiledAgent, activity: Activity, pc: int, after: int, event: TriggerCode, args: Args, new: Annots | None
) -> int:
    """No cycle is left after a belief was changed: wait for the event; without a change, go on at ``after``."""
    if new is None:
        return pause(agent, activity, after)
    activity.pc = pc
    agent.events.append(((event, args, new), activity))
    return 0


def act(
    agent: CompiledAgent,
    activity: Activity,
    pc: int,
    action: Structure,
    plan: Plan,
    statement: ExternalAction,
    left: int,
) -> int:
    """Do an external action.

    Returns:
        The cycles that the activity can use afterwards; else those not needed, as a negative number.
    """
    run = agent.run
    activity.pc = pc
    if not agent.acts_alone:
        # Anybody may perceive something in the next round.
        agent.feedback.append((activity, run.act(agent.name, action, plan, statement)))
        return 1 - left
    note_action(agent, action)
    if left == 1:
        agent.feedback.append((activity, True))
    return left - 1


def note(agent: CompiledAgent, line: int) -> None:
    """Do external actions that are always the same, in the plain environment."""
    run = agent.run
    run.actions += agent.lines[line]
    run.progress += 1


def note_action(agent: CompiledAgent, action: Structure) -> None:
    """Do an external action in the plain environment."""
    run = agent.run
    run.actions.append((agent.name, str(action)))
    run.progress += 1


def finish(agent: CompiledAgent, activity: Activity, left: int) -> int:
    """The last statement of a plan is done, and another plan may go on.

    Args:
        agent: whose plan it is.
        activity: it is its plan being executed.
        left: the cycles left.

    Returns:
        The cycles that the activity can use now; else those not needed, as a negative number.
    """
    if not returned(activity):
        return -left
    if not left:
        agent.intentions.append(activity)
    return left


def finish_acted(agent: CompiledAgent, activity: Activity, left: int) -> int:
    """As :func:`finish` where the last statement is an action, whose outcome comes in the next cycle."""
    return left if returned(activity) else 1 - left


def wait(agent: CompiledAgent, activity: Activity, ticks: float, left: int) -> int:
    """Let an activity wait; the cycles not needed, as a negative number."""
    if agent.ahead and not ticks:
        # It would be over before the others have caught up.
        return hold(agent, activity, activity.pc, left)
    run = agent.run
    since = run.ticks + agent.granted - left
    agent.waits.append(Wait(activity, since, since + ticks))
    run.note_deadline(since + ticks)
    return 1 - left
