"""ROS 2 nodes, their endpoints and parameters, with the locations in the source; and how a draft starts a node."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

EndpointKind = Literal["publisher", "subscription", "service", "client", "action server", "action client"]


@dataclass(frozen=True, order=True)
class CodeLine:
    """A line of the code: its file, relative to the folder that contains the package, and the line from 1.

    Line 0: the location is not in the source, and `file` describes where the item was observed.
    """

    file: str
    line: int

    def __str__(self) -> str:
        file = "".join(char if char.isprintable() else "?" for char in self.file)  # it stands in comments
        return f"{file}:{self.line}" if self.line else file


@dataclass(frozen=True)
class Endpoint:
    """A topic, service or action that a node publishes, subscribes to, serves or uses.

    Args:
        kind: its kind, as seen from the node.
        name: its name as ROS expands it, `/cell/scan`; empty if the source does not say it.
        type: its type, such as `std_msgs/msg/Bool`; empty if the source does not say it.
        node: name of the node; empty if unknown.
        callbacks: names of the functions that it calls back.
        location: location of the call.
    """

    kind: EndpointKind
    name: str
    type: str
    node: str
    callbacks: tuple[str, ...]
    location: CodeLine

    @property
    def is_complete(self) -> bool:
        """Whether a testbench can declare it."""
        return bool(self.name and self.type)

    @property
    def is_outgoing(self) -> bool:
        """Whether the node initiates: it publishes, or calls a service or an action."""
        return self.kind in ("publisher", "client", "action client")


@dataclass(frozen=True)
class RosParameter:
    """A parameter that a node declares; `owner` is its class, `default` the source text, empty if there is none."""

    name: str
    default: str
    owner: str
    location: CodeLine


@dataclass(frozen=True)
class RosNodes:
    """The nodes of a package and their endpoints.

    Args:
        nodes: name and location of each node; the name is empty if the source does not say it.
        endpoints: topics, services and actions, in the order of the source.
        parameters: the parameters that nodes declare.
    """

    nodes: tuple[tuple[str, CodeLine], ...] = ()
    endpoints: tuple[Endpoint, ...] = ()
    parameters: tuple[RosParameter, ...] = ()

    def of(self, *kinds: EndpointKind) -> tuple[Endpoint, ...]:
        """The endpoints of these kinds, each combination of name and type once."""
        first: dict[tuple[str, str, str, CodeLine | None], Endpoint] = {}
        for endpoint in self.endpoints:
            if endpoint.kind in kinds:
                location = None if endpoint.is_complete else endpoint.location
                first.setdefault((endpoint.kind, endpoint.name, endpoint.type, location), endpoint)
        return tuple(first.values())


@dataclass(frozen=True)
class RosStart:
    """How a draft starts a node.

    Args:
        asked: what the user named: "PACKAGE EXECUTABLE", or a path.
        entry: its entry point, "package.module:function", or a class of nodes.
        declared: topics, services and actions that requirements can name.
        interfaces: folders of message packages that are not installed.
    """

    asked: str
    entry: str
    declared: tuple[Endpoint, ...]
    interfaces: tuple[str, ...] = ()
