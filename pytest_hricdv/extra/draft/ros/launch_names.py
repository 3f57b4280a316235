"""The names that topics, services and actions of nodes have when a launch file starts these."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from pytest_hricdv.extra.draft.found.launched import StartedNode
from pytest_hricdv.extra.draft.found.nodes import Endpoint, RosNodes
from pytest_hricdv.extra.ros2.names import expand


def renamed(nodes: RosNodes, started: StartedNode) -> RosNodes:
    """What nodes have, under the names that they have when they are started like this."""
    endpoints = tuple(_renamed(endpoint, started) for endpoint in nodes.endpoints)
    names = tuple((started.name or name, place) for name, place in nodes.nodes)
    return replace(nodes, nodes=names, endpoints=endpoints)


def _renamed(endpoint: Endpoint, started: StartedNode) -> Endpoint:
    node = started.name or endpoint.node
    namespace = "/" + (started.namespace or endpoint.namespace).strip("/")
    full = _expanded(endpoint.written, node, namespace) if endpoint.written else endpoint.name
    for source, target in _rules(started.remappings, node):
        if full and _expanded(source, node, namespace) == full:
            full = _expanded(target, node, namespace)
            break
    return replace(endpoint, name=full, node=node)


def _rules(remappings: Sequence[tuple[str, str]], node: str) -> Iterator[tuple[str, str]]:
    """Those that mean a node: `talker:chatter` is of one, `chatter` of all of the process."""
    for source, target in remappings:
        of, colon, name = source.rpartition(":")
        if not colon or of == node:
            yield name, target


def _expanded(name: str, node: str, namespace: str) -> str:
    """The full name; empty where it needs the name of the node, and this is not known, or where it is none."""
    if not node and name.startswith("~"):
        return ""
    try:
        return expand(name, node or "node", namespace)
    except ValueError:
        return ""
