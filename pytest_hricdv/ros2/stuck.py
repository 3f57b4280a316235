"""Nodes that wait for ever: which, where, and for what. In a simulated run this can be known."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from typing import cast

from pytest_hricdv.ros2.graph import all_graphs
from pytest_hricdv.ros2.processes import is_of_process
from pytest_hricdv.ros2.services import Client
from pytest_hricdv.runtime import Kernel
from pytest_hricdv.runtime.kernel import Node

_WAITING_FOR_ANSWERS = {("rclpy.client", "call"), ("rclpy.executors", "spin_until_future_complete")}
_CALLING_BACK = {("rclpy.executors", "handler")}
_LIBRARIES = ("rclpy", "pytest_hricdv", "threading", "queue", "asyncio", "concurrent", "contextlib")


def stuck_nodes(kernel: Kernel, patience_s: float, *, is_idle: bool) -> list[str]:
    """What is wrong with nodes that wait for ever, a sentence each.

    It is certain of those that wait for the answer of a service that nobody serves, or for one that waits for them;
    and, of a run that is idle, of those that wait in a callback. Of others, it is a matter of patience.

    Args:
        kernel: of a run that is over, and whose nodes were not ended.
        patience_s: how long a node may wait in a callback without a time-out.
        is_idle: whether no node could go on.
    """
    found = []
    for node in kernel.nodes:
        frames = list(_frames(node))
        if not is_of_process(node) or not frames or not kernel.waits_for_ever(node):
            continue
        names = {(frame.f_globals.get("__name__"), frame.f_code.co_name) for frame in frames}
        why = _unanswered(kernel, node) if names & _WAITING_FOR_ANSWERS else ""
        waited_s = kernel.now_s - node.blocked_s
        if not why and names & _CALLING_BACK and (is_idle or waited_s >= patience_s):
            why = f"in a callback, for {waited_s:.1f} s so far, without a time-out"
        if why:
            found.append(f"{node.name} waits {_place(frames)} since {node.blocked_s:.3f} s: {why}")
    return found


def _frames(node: Node) -> Iterator[FrameType]:
    """From the innermost one on."""
    frame = node.frame
    while frame is not None:
        yield frame
        frame = frame.f_back


def _place(frames: list[FrameType]) -> str:
    """The innermost line that is none of a library."""
    for frame in frames:
        if str(frame.f_globals.get("__name__")).partition(".")[0] not in _LIBRARIES:
            return f"at {Path(frame.f_code.co_filename).name}:{frame.f_lineno}"
    return ""


def _unanswered(kernel: Kernel, node: Node) -> str:
    """For which answer the node waits that cannot come; empty if it may come."""
    asked = [
        client
        for graph in all_graphs(kernel)
        for clients in graph.clients.values()
        for client in cast("list[Client]", clients)
        if client.asked_by is node
    ]
    for client in asked:
        name = client.service_name
        if not client.servers():
            return f"for an answer of the service {name}, which nobody serves"
        if client.was_answered_before():
            return f"for an answer of the service {name}, which only the executor that waits here could take"
    return ""
