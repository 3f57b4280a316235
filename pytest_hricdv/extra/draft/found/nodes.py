"""What is found of nodes of ROS 2: plain data, each with its place, and its lines for people."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from pytest_hricdv.extra.draft.found.launched import LaunchedNodes, StartedNode
from pytest_hricdv.extra.draft.found.place import Place

Kind = Literal["publisher", "subscription", "service", "client", "action server", "action client"]


@dataclass(frozen=True)
class Endpoint:
    """A topic, service or action, where a node says, hears, serves or uses it.

    Args:
        kind: seen from the node.
        name: as ROS expands it, `/cell/scan`; empty where the source does not say it.
        type: such as `std_msgs/msg/Bool`; empty where the source does not say it.
        node: name of the node; empty where it is not known.
        callback: what is called, as the source writes it.
        place: of the call.
        written: its name as the source has it, before ROS expands it; empty where the source does not say it.
        namespace: of the node, as the source says it.
    """

    kind: Kind
    name: str
    type: str
    node: str
    callback: str
    place: Place
    written: str = ""
    namespace: str = ""

    @property
    def is_whole(self) -> bool:
        """Whether a testbench can declare it."""
        return bool(self.name and self.type)

    @property
    def is_said(self) -> bool:
        """Whether the node begins: it publishes, or asks others."""
        return self.kind in ("publisher", "client", "action client")


@dataclass(frozen=True)
class RosParameter:
    """A parameter that a node declares; `owner` is its class, `default` the source text, empty where there is none."""

    name: str
    default: str
    owner: str
    place: Place


@dataclass(frozen=True)
class Timer:
    """What a node does again and again; the period is None where the source does not say it."""

    period_s: float | None
    callback: str
    place: Place


@dataclass(frozen=True)
class RosNodes:
    """What the nodes of a package have.

    Args:
        nodes: name of each node, with where it is made; the name is empty where the source does not say it.
        endpoints: topics, services and actions, in the order of the source.
        parameters: that nodes declare, with the source text of their defaults.
        timers: of all nodes.
    """

    nodes: tuple[tuple[str, Place], ...] = ()
    endpoints: tuple[Endpoint, ...] = ()
    parameters: tuple[RosParameter, ...] = ()
    timers: tuple[Timer, ...] = ()

    def of(self, *kinds: Kind) -> tuple[Endpoint, ...]:
        """The endpoints of these kinds, each name and type once."""
        first: dict[tuple[str, str, str, Place | None], Endpoint] = {}
        for endpoint in self.endpoints:
            if endpoint.kind in kinds:
                place = None if endpoint.is_whole else endpoint.place
                first.setdefault((endpoint.kind, endpoint.name, endpoint.type, place), endpoint)
        return tuple(first.values())


@dataclass(frozen=True)
class RosStart:
    """How a draft starts a node.

    Args:
        asked: as it was asked for, "PACKAGE EXECUTABLE" or a path.
        entry: "package.module:function", or a class of nodes.
        declared: topics, services and actions that requirements can name.
        interfaces: folders of packages of messages that are not installed.
        nodes: of a launch file, the entry of each node that is Python, and how it is started.
        launch: the launch file that the draft starts as it is; None where it starts the nodes themselves.
        left_out: what the launch file starts and the draft does not, as `Launch.executables` calls it.
    """

    asked: str
    entry: str
    declared: tuple[Endpoint, ...]
    interfaces: tuple[str, ...] = ()
    nodes: tuple[tuple[str, StartedNode], ...] = ()
    launch: LaunchedNodes | None = None
    left_out: tuple[str, ...] = ()


def ros_lines(nodes: RosNodes) -> Iterator[str]:
    """What was read of nodes, for the terminal and the README."""
    counted = (
        ("topics heard", nodes.of("subscription")),
        ("topics said", nodes.of("publisher")),
        ("services served", nodes.of("service")),
        ("services used", nodes.of("client")),
        ("actions served", nodes.of("action server")),
        ("actions used", nodes.of("action client")),
    )
    names = ", ".join(name or "without a name in the source" for name, _ in nodes.nodes)
    yield f"nodes of ROS 2: {len(nodes.nodes)}{f' ({names})' if names else ''}"
    for title, endpoints in counted:
        for endpoint in endpoints:
            name = f"{endpoint.name or 'unknown name'} ({endpoint.type or 'unknown type'})"
            callback = f" -> {endpoint.callback}" if endpoint.callback else ""
            yield f"{endpoint.place}: {title}: {name}{callback}"
    for parameter in nodes.parameters:
        default = parameter.default or "none"
        yield f"{parameter.place}: parameter: {parameter.name}, default {default}"
    for timer in nodes.timers:
        period = "unknown" if timer.period_s is None else f"{timer.period_s:g} s"
        yield f"{timer.place}: timer: {period}{f' -> {timer.callback}' if timer.callback else ''}"
