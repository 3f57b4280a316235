"""A message to an agent that there is not."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.language.errors import Location

from ..model import SELF, System
from ..names import nearest


class UnknownAgent:
    """Receivers of messages that are no agents of the project."""

    name = "unknown-agent"
    why = "Sending to an agent that there is not fails, and with it the goal that it was done for."

    def findings(self, system: System) -> Iterator[tuple[Location, str]]:
        """One finding for each message; nothing for a source on its own, whose company is not known."""
        if not system.closed:
            return
        names = {agent.name for agent in system.agents}
        for agent in system.agents:
            for message in agent.sent:
                for receiver in message.receivers or ():
                    if receiver not in (*names, SELF) and nearest(receiver, names) is None:
                        yield message.location, f"there is no agent {receiver}; there are {', '.join(sorted(names))}"
