"""The mental state of compiled agents as a value that can be compared."""

from __future__ import annotations

from collections.abc import Hashable

from ..compiled import CompiledAgent
from ..compiled.activity import Activity
from ..intentions import Wait


def mental_state(agent: CompiledAgent, propositions: frozenset[Hashable], without: int | None = None) -> Hashable:
    """All of an agent that what it does next can depend on, while it is not in the middle of a cycle.

    Args:
        agent: the agent.
        propositions: its beliefs without arguments, in the form to compare.
        without: a table that does not count.

    Returns:
        The state, to be hashed: that fails if a ``for`` is under way.
    """
    tables = tuple(tuple(table.items()) for place, table in enumerate(agent.tables) if place != without)
    others = tuple((key, tuple(table.items())) for key, table in agent.others.items())
    mailbox = tuple((message.sender, message.force, message.content, message.reply_to) for message in agent.mailbox)
    queues = (
        tuple((goal, _activity(activity)) for goal, activity in agent.events),
        tuple((_activity(activity), success) for activity, success in agent.feedback),
        tuple(map(_activity, agent.intentions)),
        tuple(_wait(wait, agent.run.ticks) for wait in agent.waits),
    )
    return propositions, tables, others, mailbox, queues


def _activity(activity: Activity | None) -> Hashable:
    if activity is None:
        return None
    return activity.plan, activity.pc, activity.values, activity.goal, tuple(activity.below)


def _wait(wait: Wait, now: int) -> Hashable:
    activity = wait.intention
    assert isinstance(activity, Activity)
    return None if wait.deadline is None else wait.deadline - now, _activity(activity)
