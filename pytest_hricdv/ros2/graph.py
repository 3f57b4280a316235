"""The ROS graph of a run: who publishes, subscribes, serves and asks, in one domain."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from pytest_hricdv.runtime.kernel import Kernel


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


def graph_of(kernel: Kernel, domain: int) -> Graph:
    """The graph of a domain of a run."""
    graphs = kernel.own.setdefault("ros2 graphs", {})
    assert isinstance(graphs, dict)
    graph = graphs.setdefault(domain, Graph())
    assert isinstance(graph, Graph)
    return graph
