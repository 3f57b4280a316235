"""`Directory`: which agent offers which service, for ``.df_search`` and the other actions of a directory facilitator.

Each `SystemRun` has one; the internal actions in `bdi.actions.messages` read and change it. FIPA's name is DF.
"""

from __future__ import annotations

DIRECTORY = "df"
"""The sender of the messages that tell subscribers which agents offer a service."""


class Directory:
    """The services that agents offer, and those they subscribe to."""

    def __init__(self) -> None:
        self._providers: dict[str, set[str]] = {}
        """The agents by the text of the service."""
        self._subscribers: dict[str, dict[str, None]] = {}
        """The agents by the text of the service, in the order in which they subscribed."""

    def register(self, agent: str, service: str) -> None:
        """Register that an agent offers a service."""
        self._providers.setdefault(service, set()).add(agent)

    def deregister(self, agent: str, service: str) -> None:
        """Register that an agent no longer offers a service."""
        self._providers.get(service, set()).discard(agent)

    def subscribe(self, agent: str, service: str) -> None:
        """Subscribe an agent to the providers of a service."""
        self._subscribers.setdefault(service, {})[agent] = None

    def providers(self, service: str) -> list[str]:
        """The agents that offer a service, in the order of their names."""
        return sorted(self._providers.get(service, ()))

    def subscribers(self, service: str) -> list[str]:
        """The subscribers to a service."""
        return list(self._subscribers.get(service, ()))

    def remove(self, agent: str) -> None:
        """Remove an agent."""
        for agents in self._providers.values():
            agents.discard(agent)
        for subscribers in self._subscribers.values():
            subscribers.pop(agent, None)
