"""The ROS graph of a run: who publishes, subscribes, serves and asks, in one domain; and notes on it for the report."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol, cast

from pytest_hricdv.runtime.kernel import Kernel


class Carrier(Protocol):
    """Sees what goes over topics and services; see `bridge.Bridge`."""

    def admit(self, domain: int, node: str, full_name: str, kind: str) -> None: ...

    def carry(
        self,
        node: str,
        full_name: str,
        direction: str,
        message: Any,
        deliver: Callable[[], None],
        is_heard: Callable[[], bool],
        reliable: Callable[[], str] = ...,
    ) -> None: ...


@dataclass
class Graph:
    """All that is there in one domain of a run, each in the order in which it was made.

    It is below those whom it lists, so it does not know their classes.
    """

    nodes: list[Any] = field(default_factory=list)
    """Of `contexts.Node`."""
    publishers: dict[str, list[Any]] = field(default_factory=dict)
    """Full name of a topic -> its `topics.Publisher`s."""
    subscriptions: dict[str, list[Any]] = field(default_factory=dict)
    """Full name of a topic -> its `topics.Subscription`s."""
    services: dict[str, list[Any]] = field(default_factory=dict)
    """Full name of a service -> its `services.Service`s."""
    clients: dict[str, list[Any]] = field(default_factory=dict)
    """Full name of a service -> its `services.Client`s."""

    def entities(self) -> list[Any]:
        """Publishers, subscriptions, services and clients."""
        kinds = (self.publishers, self.subscriptions, self.services, self.clients)
        return [entity for kind in kinds for group in kind.values() for entity in group]

    carrier: Carrier | None = None
    """Carries what is sent; None: it is delivered, and nobody else sees it."""


_GRAPHS, _CARRIER, _NOTES = "ros2 graphs", "ros2 carrier", "ros2 notes"


def graph_of(kernel: Kernel, domain: int) -> Graph:
    """The graph of a domain of a run."""
    graphs = kernel.own.setdefault(_GRAPHS, {})
    assert isinstance(graphs, dict)
    graph = graphs.setdefault(domain, Graph(carrier=cast("Carrier | None", kernel.own.get(_CARRIER))))
    assert isinstance(graph, Graph)
    return graph


def all_graphs(kernel: Kernel) -> list[Graph]:
    """Those of all domains of a run."""
    return list(cast("dict[int, Graph]", kernel.own.get(_GRAPHS, {})).values())


def carry_with(kernel: Kernel, carrier: Carrier) -> None:
    """Let the graphs of a run have a carrier; to be called before there are any."""
    kernel.own[_CARRIER] = carrier


def note(kernel: Kernel, sentence: str) -> None:
    """Keep a sentence for the report; it names no time, so that runs say the same of the same."""
    notes = kernel.own.setdefault(_NOTES, {})
    assert isinstance(notes, dict)
    notes.setdefault(sentence)


def notes_of(kernel: Kernel) -> tuple[str, ...]:
    """The notes of a run, in the order in which they were made."""
    notes = kernel.own.get(_NOTES, {})
    assert isinstance(notes, dict)
    return tuple(notes)
