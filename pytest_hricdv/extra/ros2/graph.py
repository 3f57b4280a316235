"""`Graph`, the ROS graph of one domain in a run: publishers, subscriptions, services, clients, and notes on them.

`graph_of` returns the graph of a domain; each `Context` has one. What joins it is a `GraphEntity`. `carry_with` sets
the `Bridge` of a run, `note` adds a note, and `notes_of` returns all notes to `Ros2Overlay` after the run. The other
functions answer the queries of `rclpy`, such as for the names and types of topics.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Protocol, cast

from pytest_hricdv.extra.ros2.handles import Destroyable, RCLError
from pytest_hricdv.extra.ros2.messages import type_name
from pytest_hricdv.runtime.kernel import Kernel

NamesAndTypes = list[tuple[str, list[str]]]
"""Full names of topics or services, each with its types."""
_Entities = dict[str, list[Any]]


class NodeNameNonExistentError(RCLError):
    """Like the error of `rclpy`'s extension: there is no node of this name."""


class Carrier(Protocol):
    """Delivers what is sent over topics and services; implemented by `bridge.Bridge`."""

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


class GraphEntity(Destroyable):
    """A publisher, subscription, service or client. It leaves the graph when it is destroyed, or its context ends."""

    node: Any
    """A `contexts.GraphNode`."""
    kind: type[Any]
    full_name: str
    """The full name of its topic or service."""
    _group: list[Any]

    def _join(self, entities: _Entities) -> None:
        """Enter the graph, among the entities of its kind."""
        self._group = entities.setdefault(self.full_name, [])
        self._group.append(self)

    def destroy(self) -> None:
        """Leave the graph."""
        self.leave()

    def leave(self) -> None:
        """Leave the graph; a second time has no effect."""
        if self in self._group:
            self._group.remove(self)
            self._on_leave()

    def _on_leave(self) -> None:
        """A hook for subclasses after they have left."""

    def get_logger_name(self) -> str:
        """The name of its node's logger."""
        return str(self.node.logger_name())


@dataclass
class Graph:
    """The entities of one domain of a run, in the order of creation: full name of a topic or service -> entities.

    It is a layer below them, so it does not know their classes.
    """

    nodes: list[Any] = field(default_factory=list)
    publishers: _Entities = field(default_factory=dict)
    subscriptions: _Entities = field(default_factory=dict)
    services: _Entities = field(default_factory=dict)
    clients: _Entities = field(default_factory=dict)
    carrier: Carrier | None = None
    """Carries sent messages; None: they are delivered directly, unseen."""

    def entities(self) -> list[Any]:
        """Publishers, subscriptions, services and clients."""
        kinds = (self.publishers, self.subscriptions, self.services, self.clients)
        return [entity for kind in kinds for group in kind.values() for entity in group]


_GRAPHS, _CARRIER, _NOTES = "ros2 graphs", "ros2 carrier", "ros2 notes"


def graph_of(kernel: Kernel, domain: int) -> Graph:
    """The graph of a domain of a run."""
    graphs = cast("dict[int, Graph]", kernel.own.setdefault(_GRAPHS, {}))
    return graphs.setdefault(domain, Graph(carrier=cast("Carrier | None", kernel.own.get(_CARRIER))))


def all_graphs(kernel: Kernel) -> list[Graph]:
    """The graphs of all domains of a run."""
    return list(cast("dict[int, Graph]", kernel.own.get(_GRAPHS, {})).values())


def carry_with(kernel: Kernel, carrier: Carrier) -> None:
    """Let the graphs of a run have a carrier; to be called before there are any."""
    kernel.own[_CARRIER] = carrier


def note(kernel: Kernel, sentence: str) -> None:
    """Keep a sentence for the report; it names no time, so that runs say the same of the same."""
    cast("dict[str, None]", kernel.own.setdefault(_NOTES, {})).setdefault(sentence)


def notes_of(kernel: Kernel) -> tuple[str, ...]:
    """The notes of a run, in the order in which they were made."""
    return tuple(cast("dict[str, None]", kernel.own.get(_NOTES, {})))


def _names_and_types(entities: Iterable[Mapping[str, Sequence[Any]]]) -> NamesAndTypes:
    types: dict[str, set[str]] = {}
    for groups in entities:
        for name, group in groups.items():
            for entity in group:
                types.setdefault(name, set()).add(type_name(entity.kind))
    return [(name, sorted(types[name])) for name in sorted(types)]


def topic_names_and_types(node: Any, no_demangle: bool) -> NamesAndTypes:
    """All topics."""
    return _names_and_types([node.graph.publishers, node.graph.subscriptions])


def service_names_and_types(node: Any) -> NamesAndTypes:
    """All services with servers or clients."""
    return _names_and_types([node.graph.services, node.graph.clients])


def _node_entities(part: str, node: Any, *arguments: Any) -> NamesAndTypes:
    """A node's entities in a part of the graph.

    Args:
        part: attribute of the graph.
        node: the node that asks.
        arguments: for topics whether names are kept as they are; then name and namespace of the other node.

    Raises:
        NodeNameNonExistentError: there is no such node.
    """
    *_, name, namespace = arguments

    def is_meant(other: Any) -> bool:
        return bool((other.get_node_name(), other.get_namespace()) == (name, namespace))

    if not any(map(is_meant, node.graph.nodes)):
        raise NodeNameNonExistentError(f"cannot get names and types for nonexistent node {namespace}/{name}")
    entities = getattr(node.graph, part)
    return _names_and_types([{key: [own for own in group if is_meant(own.node)] for key, group in entities.items()}])


publishers_by_node = partial(_node_entities, "publishers")
subscribers_by_node = partial(_node_entities, "subscriptions")
services_by_node = partial(_node_entities, "services")
clients_by_node = partial(_node_entities, "clients")

_FEEDBACK_TOPIC, _FEEDBACK_TYPE = "/_action/feedback", "_FeedbackMessage"


def _actions(topics: NamesAndTypes) -> NamesAndTypes:
    """The actions, known by their topics for feedback."""
    return [
        (name.removesuffix(_FEEDBACK_TOPIC), [kind.removesuffix(_FEEDBACK_TYPE) for kind in kinds])
        for name, kinds in topics
        if name.endswith(_FEEDBACK_TOPIC)
    ]


def actions(node: Any) -> NamesAndTypes:
    """All actions."""
    return _actions(topic_names_and_types(node, False))


def action_clients_by_node(node: Any, name: str, namespace: str) -> NamesAndTypes:
    """The actions that a node asks for. Raises NodeNameNonExistentError, as the following one."""
    return _actions(subscribers_by_node(node, name, namespace))


def action_servers_by_node(node: Any, name: str, namespace: str) -> NamesAndTypes:
    """The actions that a node serves."""
    return _actions(publishers_by_node(node, name, namespace))


def _info(part: str, endpoint_type: int, node: Any, topic: str, no_mangle: bool) -> list[dict[str, Any]]:
    """The publishers or subscriptions of a topic, as dictionaries that `rclpy` reads."""
    return [
        {
            "node_name": endpoint.node.get_node_name(),
            "node_namespace": endpoint.node.get_namespace(),
            "topic_type": type_name(endpoint.kind),
            "topic_type_hash": {"version": 1, "value": bytes(32)},
            "endpoint_type": endpoint_type,
            "endpoint_gid": list(endpoint.pointer.to_bytes(16, "big")),
            "qos_profile": endpoint.profile.to_dict(),
        }
        for endpoint in getattr(node.graph, part).get(topic, ())
    ]


publishers_info = partial(_info, "publishers", 1)
subscriptions_info = partial(_info, "subscriptions", 2)
