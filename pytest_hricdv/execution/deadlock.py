"""Deadlocks: nodes of a run that wait for locks of each other."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pytest_hricdv.runtime import Node
from pytest_hricdv.runtime.source_location import place_of
from pytest_hricdv.runtime.virtual.locks import lock_waited_for


def find_deadlocks(nodes: Sequence[Node]) -> Iterator[str]:
    """A sentence for each circle of nodes, while they wait.

    A node that waits for a lock which it took itself is none: another one may release it, as a signal.
    """
    waits = {node: lock for node in nodes if (lock := lock_waited_for(node)) is not None}
    named: set[Node] = set()
    for node in waits:
        circle: list[Node] = []
        here: Node | None = node
        while here in waits and here not in circle and here not in named:
            circle.append(here)
            here = waits[here].holder
        if here in circle:
            circle = circle[circle.index(here) :]
            named.update(circle)
        if here in circle and len(circle) > 1:
            yield f"deadlock: {'; '.join(_wait(one, waits[one].holder) for one in circle)}"


def _wait(node: Node, holder: Node | None) -> str:
    assert holder is not None
    return f"{node.name} waits at {place_of(node.frame)} for a lock that {holder.name} holds"
