"""The mental state of compiled agents as a value that can be compared, and from which an agent can go on."""

from __future__ import annotations

from collections import deque
from collections.abc import Hashable, Iterable
from typing import Any, NamedTuple

from ..compiled import CompiledAgent
from ..compiled.activity import Activity
from ..intentions import Letter, Message, Wait


class MentalState(NamedTuple):
    """All of an agent that what it does next can depend on, while it is not in the middle of a cycle.

    A named tuple because it is hashed all the time; that fails if a ``for`` is under way.

    Args:
        propositions: its beliefs without arguments, with their annotations; None for those certainly not held.
        tables: its other beliefs, those that its program tests by their place, the oldest first.
        others: the rest of them by key.
        mailbox: the messages, either letters or what makes them up.
        events: what events are about, and the activities that wait for them.
        feedback: the activities to hear of an action, and its success.
        intentions: the activities that are ready.
        waits: the activities that wait, and for how many ticks yet.
    """

    propositions: frozenset[Any]
    tables: tuple[Any, ...]
    others: tuple[Any, ...]
    mailbox: tuple[Any, ...]
    events: tuple[Any, ...]
    feedback: tuple[Any, ...]
    intentions: tuple[Any, ...]
    waits: tuple[Any, ...]


def mental_state(
    agent: CompiledAgent, now: int, propositions: Iterable[Hashable], without: int | None = None
) -> MentalState:
    """The state of an agent.

    Args:
        agent: the agent.
        now: the tick of the virtual clock.
        propositions: its beliefs without arguments.
        without: a table that does not count.
    """
    return MentalState(
        frozenset(propositions),
        tuple([tuple(table.items()) for place, table in enumerate(agent.tables) if place != without]),
        tuple([(key, tuple(table.items())) for key, table in agent.others.items()]),
        tuple([_message(message) for message in agent.mailbox]),
        tuple([(goal, _activity(activity)) for goal, activity in agent.events]),
        tuple([(_activity(activity), success) for activity, success in agent.feedback]),
        tuple([_activity(activity) for activity in agent.intentions]),
        tuple([(_left(wait, now), _activity(wait.intention)) for wait in agent.waits]),
    )


def restore(agent: CompiledAgent, state: MentalState, without: int | None = None) -> None:
    """Put an agent into a state, its propositions aside; ``without`` is as in :func:`mental_state`."""
    places = [place for place in range(len(agent.tables)) if place != without]
    for place, content in zip(places, state.tables, strict=True):
        agent.tables[place] = dict(content)
    agent.others = {key: dict(content) for key, content in state.others}
    agent.mailbox = deque(map(_sent, state.mailbox))
    agent.events = deque((goal, None if activity is None else _begun(activity)) for goal, activity in state.events)
    agent.feedback = deque((_begun(activity), success) for activity, success in state.feedback)
    agent.intentions = deque(map(_begun, state.intentions))
    agent.waits = []
    for left, activity in state.waits:
        deadline = None if left is None else agent.run.ticks + left
        agent.waits.append(Wait(_begun(activity), agent.run.ticks, deadline))
        if deadline is not None:
            agent.run.note_deadline(deadline)
    agent.note_seen()


def _message(message: Message) -> Hashable:
    """A letter is the same object every time; of other messages, their numbers make no difference here."""
    return message if type(message) is Letter else (message.sender, message.force, message.content, message.reply_to)


def _sent(message: Any) -> Message:
    if type(message) is Letter:
        return message
    sender, force, content, reply_to = message
    return Message(sender, force, content, "", reply_to)


def _activity(activity: object) -> Hashable:
    if activity is None:
        return None
    assert isinstance(activity, Activity)
    return activity.plan, activity.pc, activity.values, activity.goal, tuple(activity.below)


def _begun(state: Any) -> Activity:
    plan, pc, values, goal, below = state
    activity = Activity(0, plan, values, goal)
    activity.pc = pc
    activity.below = list(below)
    activity.open = sum(caller.after[at] != caller.end for caller, at, _, _ in below)
    return activity


def _left(wait: Wait, now: int) -> float | None:
    return None if wait.deadline is None else wait.deadline - now
