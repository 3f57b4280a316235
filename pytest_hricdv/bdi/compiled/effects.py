"""What statements of a compiled agent do besides changing its beliefs."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..intentions import Message, Wait
from ..terms import Term
from .activity import Activity, Goal, begin, returned
from .runtime import BailError

if TYPE_CHECKING:
    from .agent import CompiledAgent


def enter(agent: CompiledAgent, activity: Activity, goal: Goal, left: int) -> int:
    """Post an event that an activity waits for and react to it at once, as nothing can come between.

    Returns:
        The cycles left.
    """
    trigger, args, annots = goal
    select = trigger.select
    try:
        selected = None if select is None else select(agent, args, annots)
        if selected is None:
            if trigger.is_goal:
                raise BailError
            # A belief event that no plan is for.
            activity.pc = activity.plan.after[activity.pc]
            return left
    except BailError:
        activity.left = left
        agent.events.appendleft((goal, activity))
        raise
    begin(activity, goal, *selected)
    return left


def finish(agent: CompiledAgent, activity: Activity, left: int) -> int:
    """The last statement of a plan is done.

    Args:
        agent: whose plan it is.
        activity: it is its plan being executed.
        left: the cycles left.

    Returns:
        The cycles that the activity can use now.
    """
    if returned(activity):
        if left:
            return left
        agent.intentions.append(activity)
    else:
        agent.unused += left
    return 0


def finish_acted(agent: CompiledAgent, activity: Activity, left: int) -> int:
    """As :func:`finish` where the last statement is an action, whose outcome comes in the next cycle."""
    if returned(activity):
        return left
    agent.unused += left - 1
    return 0


def send(agent: CompiledAgent, receiver: str, force: str, content: Term) -> None:
    """Send a message."""
    run = agent.run
    to = run.agents[receiver]
    run.deliver(to, Message("self" if to is agent else agent.name, force, content, run.next_message_number()))


def post(agent: CompiledAgent, receiver: str, number: int) -> None:
    """Send a message that is always the same; ``number`` is its place among those of the program."""
    run = agent.run
    to = run.agents[receiver]
    if to.takes_letters:
        run.sent += 1
        run.progress += 1
        to.mailbox.append(agent.letters[number])
        if not to.awake:
            run.wake(to)
    else:
        letter = agent.letters[number]
        send(agent, receiver, letter.force, letter.content)


def wait(agent: CompiledAgent, activity: Activity, wait_ms: float, left: int) -> int:
    """Let an activity wait; the cycles that it can use now: none."""
    run = agent.run
    since = run.ticks + agent.granted - left
    deadline = run.after(wait_ms) + since - run.ticks
    agent.waits.append(Wait(activity, since, deadline))  # type: ignore[arg-type]
    run.note_deadline(deadline)
    agent.unused += left - 1
    return 0
