"""Messages of compiled agents, and how far their senders may go on at once.

A message is seen by its receiver when that next does a cycle. An agent that is alone, and then gives one that was idle
something to do, would do every second cycle from then on. Instead it goes on at once for as long as its receiver
certainly keeps to itself, ahead of the run's clock, unless it comes to another message: that has to wait until the
others have caught up.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from pytest_hricdv.bdi.language.terms import Structure, Term

from ..intentions import Letter, Message
from .activity import Activity, Args
from .calm import CALM

if TYPE_CHECKING:
    from ..participant import Participant
    from .agent import CompiledAgent


def filled(agent: CompiledAgent, form: int, content: Args | Structure) -> Letter:
    """The letter of a form with these arguments, or with this content."""
    try:
        return agent.known[form, content]
    except (KeyError, RecursionError):
        # Terms nested too deeply to be looked up are for the receiver to complain about.
        return agent.code.letter(form, content)


def lettered(agent: CompiledAgent, force: str, form: int, content: Term) -> Message:
    """The message of a form of which nothing is known beforehand."""
    if type(content) is Structure and content.ground:
        return filled(agent, form, content)
    return Message(agent.name, force, content, "")


def post(agent: CompiledAgent, receiver: str, message: Message) -> None:
    """Send a message."""
    _put(agent, agent.run.agents[receiver], message)


def _put(agent: CompiledAgent, to: Participant, message: Message) -> None:
    run = agent.run
    if to.takes_letters and type(message) is Letter:
        run.sent += 1
        run.progress += 1
        to.mailbox.append(message)
        if not to.awake:
            run.wake(to)
    else:
        sender = "self" if to is agent else agent.name
        run.deliver(to, Message(sender, message.force, message.content, run.next_message_number()))


def post_on(
    agent: CompiledAgent, activity: Activity, pc: int, after: int, receiver: str, message: Message, left: int
) -> int:
    """Send a message, which is the statement ``pc``, and go on if nothing can come between.

    Returns:
        The cycles that the activity can use now for the statement ``after``; else those not needed, as a negative
        number.
    """
    if agent.ahead:
        return hold(agent, activity, pc, left)
    to = agent.run.agents[receiver]
    calm = _calm(to, message) if left > 1 and agent.goes_ahead and agent.run.held is None else 0
    _put(agent, to, message)
    if not calm:
        activity.pc = after
        agent.intentions.append(activity)
        return 1 - left
    agent.ahead = agent.granted - left + 1
    left -= 1
    if left > calm:
        agent.granted -= left - calm
        left = calm
    return left


def hold(agent: CompiledAgent, activity: Activity, pc: int, left: int) -> int:
    """Wait for the others to catch up before a message is sent; the cycles not needed, as a negative number."""
    activity.pc = pc
    agent.intentions.append(activity)
    return -left


def _calm(to: Participant, message: Message) -> int:
    """For how many cycles the receiver will keep to itself if it gets a message now."""
    if to.awake or to.mailbox or type(message) is not Letter or not to.takes_letters:
        return 0
    event = message.event
    if to.spin is not None:
        # It selects a plan for what it looks for in the same cycle.
        (goal, looking), *_ = to.events  # type: ignore[attr-defined]
        return 0 if event is not None else goal[0].calm[looking.open > 0]
    return CALM if event is None else event[0][0].calm[0]
