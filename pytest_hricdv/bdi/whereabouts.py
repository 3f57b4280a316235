"""Where an agent's intentions are: in which of its queues, or waiting for what."""

from __future__ import annotations

from collections import deque

from .intentions import Event, Intention
from .mind import Mind


def everywhere(agent: Mind) -> list[tuple[Intention, Event | None]]:
    """All intentions, whatever they are doing or waiting for, and the goal events that wait for a plan."""
    found: list[tuple[Intention, Event | None]] = []
    found += [(event.intention or Intention(0), event) for event in agent.events]
    found += [(intention, None) for intention in agent.intentions]
    found += [(intention, None) for intention, _ in agent.feedback]
    found += [(wait.intention, None) for wait in agent.waits]
    found += [(intention, None) for intention in agent.woken]
    found += [(question.intention, None) for question in agent.questions.values()]
    found += [(intention, None) for intention in agent.suspended]
    if agent.current is not None:
        found.append((agent.current, None))
    return found


def take_out(agent: Mind, intention: Intention) -> None:
    """Take an intention out of whatever it is in; it is neither ready nor waiting any more."""
    agent.events = deque(event for event in agent.events if event.intention is not intention)
    agent.intentions = deque(other for other in agent.intentions if other is not intention)
    agent.feedback = deque(entry for entry in agent.feedback if entry[0] is not intention)
    agent.waits = [wait for wait in agent.waits if wait.intention is not intention]
    agent.woken = [other for other in agent.woken if other is not intention]
    questions = agent.questions.items()
    agent.questions = {number: asked for number, asked in questions if asked.intention is not intention}
    agent.suspended = [other for other in agent.suspended if other is not intention]
