"""Finds nodes that wait for ever: where, and for what. A simulated run can tell."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType
from typing import Any, cast

from pytest_hricdv.extra.ros2.actions import ActionClient
from pytest_hricdv.extra.ros2.graph import all_graphs
from pytest_hricdv.extra.ros2.processes import process_of
from pytest_hricdv.extra.ros2.services import Client
from pytest_hricdv.runtime import Kernel
from pytest_hricdv.runtime.kernel import Node
from pytest_hricdv.runtime.source_location import place_of

_WAITING_FOR_RESPONSES = {
    ("rclpy.client", "call"),
    ("rclpy.executors", "spin_until_future_complete"),
    ("rclpy.action.client", "send_goal"),
}
_WAITING_FOR_SERVERS = {("rclpy.client", "wait_for_service"), ("rclpy.action.client", "wait_for_server")}
_CALLING_BACK = {("rclpy.executors", "handler")}
_AT_A_TERMINAL = {("pytest_hricdv.runtime.virtual.terminal", "wait_readable")}
_SPINNING = {
    ("rclpy.executors", "_wait_for_ready_callbacks"),
    ("pytest_hricdv.extra.ros2.executor", "wait_for_ready_callbacks"),
}


def stuck_nodes(kernel: Kernel, idle_timeout_s: float, *, is_idle: bool) -> list[str]:
    """A sentence on each node that waits for ever.

    This is certain for nodes that wait, without a time-out, for a service that nobody serves or for a response that
    waits for them; and, if the run is idle, for nodes that wait in a callback. Other nodes count if they have waited
    for `idle_timeout_s`.

    Args:
        kernel: of a run that is over, but whose nodes were not ended.
        idle_timeout_s: how long a node may wait (simulated s).
        is_idle: whether no node could continue.
    """
    nodes = [_Wait(kernel, node, frames) for node in kernel.nodes if (frames := _frames(node))]
    least_s = 0.0 if is_idle else idle_timeout_s
    blocked = [sentence for node in nodes if (sentence := node.block_reason(least_s))]
    return blocked + [request for node in nodes for request in node.requests_without_server(least_s)]


def _frames(node: Node) -> list[FrameType]:
    """The frames of a waiting node of the system, from the innermost one on."""
    frames, frame = [], node.frame if process_of(node) is not None and not node.ended else None
    while frame is not None:
        frames.append(frame)
        frame = frame.f_back
    return frames


def _function(frame: FrameType) -> tuple[str, str]:
    """Module and name of a function."""
    return str(frame.f_globals.get("__name__")), frame.f_code.co_name


def _line(place: str) -> str:
    """File and line without the folder."""
    return Path(place).name


@dataclass
class _Wait:
    """A node of the kernel that waits."""

    kernel: Kernel
    node: Node
    frames: Sequence[FrameType]
    functions: set[tuple[str, str]] = field(init=False)

    def __post_init__(self) -> None:
        self.functions = {_function(frame) for frame in self.frames}

    def block_reason(self, least_s: float) -> str:
        """What it waits for in vain, if it has waited this long, or certainly; empty if it may continue."""
        since_s, why = self._for_server(least_s)
        if not why and self.kernel.waits_for_ever(self.node):
            since_s, why = self.node.blocked_s, self._for_ever(least_s)
        place = _line(place_of(self.frames[0]))
        return f"{self.node.name} waits at {place} since {since_s:.3f} s: {why}" if why else ""

    def _for_server(self, least_s: float) -> tuple[float, str]:
        """Since when it has looked for which server, in `wait_for_service`."""
        for frame in self.frames:
            if _function(frame) not in _WAITING_FOR_SERVERS:
                continue
            client, timeout_s = _client_of(frame.f_locals.get("self")), frame.f_locals.get("timeout_sec")
            if client is None or client.missed_since_s is None or client.servers():
                break
            is_endless = timeout_s is None or math.isinf(timeout_s)
            # At least an instant: a client that looks for the first time now has not waited in vain yet.
            if is_endless or self.kernel.now_s - client.missed_since_s >= max(least_s, 1e-6):
                return client.missed_since_s, f"for {_client_text(client)}, which nobody serves"
        return 0.0, ""

    def _for_ever(self, least_s: float) -> str:
        """What it waits for without a time-out that cannot come, or has not come for this long."""
        clients = self._last_clients() if self.functions & _WAITING_FOR_RESPONSES else []
        for client in clients:
            if not client.servers():
                return f"for the response of {_client_text(client)}, which nobody serves"
            if client.was_answered_before():
                return f"for the response of {_client_text(client)}, which only the executor that waits here could take"
        waited_s = self.kernel.now_s - self.node.blocked_s
        reads_keys = bool(self.functions & _AT_A_TERMINAL)  # a person may take as long as they like
        if waited_s < least_s or reads_keys or not self.functions & _CALLING_BACK:
            return ""
        so_far = f"in a callback, for {waited_s:.1f} s so far, without a time-out"
        for client in clients:
            if client.is_unanswered():
                server = client.servers()[0].node.get_fully_qualified_name()
                return f"for the response of {_client_text(client)} of {server}, {so_far}"
        return so_far

    def _last_clients(self) -> list[Client]:
        """The clients with which it has asked last."""
        graphs = all_graphs(self.kernel)
        clients = [client for graph in graphs for group in graph.clients.values() for client in group]
        return [client for client in cast("list[Client]", clients) if client.asked_by is self.node]

    def requests_without_server(self, least_s: float) -> Iterator[str]:
        """Requests of its executor's clients whose response is still awaited without a server."""
        spinning = next((frame for frame in self.frames if _function(frame) in _SPINNING), None)
        nodes = [] if spinning is None else spinning.f_locals["self"].get_nodes()
        for client, numbers in (pending for node in nodes for pending in _open_requests(node)):
            lost = [client.lost[number] for number in numbers if number in client.lost]
            if lost and not client.servers() and self.kernel.now_s - lost[0].time_s >= least_s:
                where = f"at {_line(lost[0].place)} at {lost[0].time_s:.3f} s"
                yield f"{self.node.name} calls {_client_text(client)} {where}: nobody serves it"


def _client_of(owner: Any) -> Client | None:
    """The client behind an object of `rclpy`: a client, or a client of an action."""
    handle = getattr(owner, "handle", None) or getattr(owner, "_client_handle", None)
    if isinstance(handle, ActionClient):
        return handle.goal
    return handle if isinstance(handle, Client) else None


def _open_requests(node: Any) -> Iterator[tuple[Client, list[int]]]:
    """The clients of a node of `rclpy`, and the numbers of the requests whose responses it still wants."""
    for owner, wanted in (
        *((client, "_pending_requests") for client in node.clients),
        *((waitable, "_pending_goal_requests") for waitable in node.waitables),
    ):
        client = _client_of(owner)
        if client is not None:
            yield client, list(getattr(owner, wanted, ()))


def _client_text(client: Client) -> str:
    """The client's service, as its author calls it."""
    name, _, part = client.service_name.partition("/_action/")
    return f"the action {name}" if part else f"the service {name}"
