"""What code can ask of the ROS graph."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Protocol

from pytest_hricdv.extra.ros2.contexts import NamesAndTypes, Node
from pytest_hricdv.extra.ros2.handles import RCLError
from pytest_hricdv.extra.ros2.messages import type_name
from pytest_hricdv.extra.ros2.topics import Publisher, Subscription


class NodeNameNonExistentError(RCLError):
    """As of the extension."""


class _OfNode(Protocol):
    """What belongs to a node and has a type."""

    @property
    def node(self) -> Node: ...

    kind: type[Any]


_Entities = Mapping[str, Sequence[_OfNode]]
_PUBLISHER, _SUBSCRIPTION = 1, 2


def _names_and_types(entities: Iterable[_Entities]) -> NamesAndTypes:
    types: dict[str, set[str]] = {}
    for groups in entities:
        for name, group in groups.items():
            for entity in group:
                types.setdefault(name, set()).add(type_name(entity.kind))
    return [(name, sorted(types[name])) for name in sorted(types)]


def _of_node(node: Node, entities: _Entities, name: str, namespace: str) -> NamesAndTypes:
    nodes = [(other.get_node_name(), other.get_namespace()) for other in node.graph.nodes]
    if (name, namespace) not in nodes:
        raise NodeNameNonExistentError(f"cannot get names and types for nonexistent node {namespace}/{name}")

    def is_of_node(entity: _OfNode) -> bool:
        return (entity.node.get_node_name(), entity.node.get_namespace()) == (name, namespace)

    return _names_and_types(
        [{key: [entity for entity in group if is_of_node(entity)] for key, group in entities.items()}]
    )


def topic_names_and_types(node: Node, no_demangle: bool) -> NamesAndTypes:
    """All topics."""
    return _names_and_types([node.graph.publishers, node.graph.subscriptions])


def service_names_and_types(node: Node) -> NamesAndTypes:
    """All services that are served or asked."""
    return _names_and_types([node.graph.services, node.graph.clients])


def publishers_by_node(node: Node, no_demangle: bool, name: str, namespace: str) -> NamesAndTypes:
    """What a node publishes. Raises NodeNameNonExistentError, as the following ones."""
    return _of_node(node, node.graph.publishers, name, namespace)


def subscribers_by_node(node: Node, no_demangle: bool, name: str, namespace: str) -> NamesAndTypes:
    """What a node subscribes."""
    return _of_node(node, node.graph.subscriptions, name, namespace)


def services_by_node(node: Node, name: str, namespace: str) -> NamesAndTypes:
    """What a node serves."""
    return _of_node(node, node.graph.services, name, namespace)


def clients_by_node(node: Node, name: str, namespace: str) -> NamesAndTypes:
    """What a node asks."""
    return _of_node(node, node.graph.clients, name, namespace)


_FEEDBACK_TOPIC, _FEEDBACK_TYPE = "/_action/feedback", "_FeedbackMessage"


def _actions(topics: NamesAndTypes) -> NamesAndTypes:
    """Those of an action's topics that tell it."""
    return [
        (name.removesuffix(_FEEDBACK_TOPIC), [kind.removesuffix(_FEEDBACK_TYPE) for kind in kinds])
        for name, kinds in topics
        if name.endswith(_FEEDBACK_TOPIC)
    ]


def actions(node: Node) -> NamesAndTypes:
    """All actions."""
    return _actions(topic_names_and_types(node, False))


def action_clients_by_node(node: Node, name: str, namespace: str) -> NamesAndTypes:
    """The actions that a node asks for. Raises NodeNameNonExistentError, as the following one."""
    return _actions(subscribers_by_node(node, False, name, namespace))


def action_servers_by_node(node: Node, name: str, namespace: str) -> NamesAndTypes:
    """The actions that a node serves."""
    return _actions(publishers_by_node(node, False, name, namespace))


def _info(endpoint: Publisher | Subscription, kind: int) -> dict[str, Any]:
    return {
        "node_name": endpoint.node.get_node_name(),
        "node_namespace": endpoint.node.get_namespace(),
        "topic_type": type_name(endpoint.kind),
        "topic_type_hash": {"version": 1, "value": bytes(32)},
        "endpoint_type": kind,
        "endpoint_gid": list(endpoint.pointer.to_bytes(16, "big")),
        "qos_profile": endpoint.profile.to_dict(),
    }


def publishers_info(node: Node, topic: str, no_mangle: bool) -> list[dict[str, Any]]:
    """Who publishes a topic."""
    return [_info(publisher, _PUBLISHER) for publisher in node.graph.publishers.get(topic, ())]


def subscriptions_info(node: Node, topic: str, no_mangle: bool) -> list[dict[str, Any]]:
    """Who subscribes to a topic."""
    return [_info(subscription, _SUBSCRIPTION) for subscription in node.graph.subscriptions.get(topic, ())]
