"""Calls of nodes that would wait in real time: served in virtual time, or refused with the line of the call."""

from __future__ import annotations

import sys

from pytest_hricdv.runtime.blocking_calls import KINDS, virtual_time
from pytest_hricdv.runtime.kernel import Node, current_node
from pytest_hricdv.runtime.node_error import KernelError
from pytest_hricdv.runtime.source_location import place_of

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all


class ProhibitedError(KernelError):
    """The code under test asked for what it cannot have; the run knows of it, so it cannot be caught and forgotten."""

    def __init__(self, text: str) -> None:
        super().__init__(text)
        node = current_node()
        if node is not None:
            node.kernel.refusals.append(self)


class RealTimeError(ProhibitedError):
    """It asked for real time; the message says where, and how to let it have virtual time."""


def check(node: Node, kind: str, name: str) -> None:
    """Refuse what the testbench did not ask to have in virtual time.

    Args:
        node: which wants to wait, or to know the time.
        kind: one of `KINDS`.
        name: what it uses.

    Raises:
        RealTimeError: the kind is not virtual.
    """
    virtual = node.kernel.virtual
    if kind in virtual:
        return
    place = place_of(sys._getframe(1))
    raise RealTimeError(
        f"{place}: {name} in node {node.name} is real time, which a simulated run does not have: give "
        f"the testbench {virtual_time([kind], virtual)} to have {KINDS[kind]} in virtual time, "
        "or let the code use the clock of its port"
    )


def node_to_wait(kind: str, name: str) -> Node:
    """The running node, which is about to wait.

    Raises:
        KernelError: outside of a node: the world, for instance, cannot wait for what a node does.
        RealTimeError: see `check`.
    """
    node = current_node()
    if node is None:
        raise KernelError(
            f"{place_of(sys._getframe(1))}: {name} would wait for ever: only a node may wait, and this is not one"
        )
    check(node, kind, name)
    return node
