"""Finds nodes that wait without end when a run is over: for locks of each other, or for a wake-up that never comes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from pytest_hricdv.runtime.kernel import Node
from pytest_hricdv.runtime.source_location import module_place_of, place_of
from pytest_hricdv.runtime.virtual.locks import Lock, WaitQueue

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all


def _object_of_call(node: Node, function: Callable[..., object]) -> object:
    """The object whose method a node waits in; None if it does something else."""
    frame = node.frame
    while frame is not None:
        if frame.f_code is function.__code__:
            return frame.f_locals["self"]
        frame = frame.f_back
    return None


def _lock_waited_for(node: Node) -> Lock | None:
    """The lock that a node waits for without a time-out; None if it does something else."""
    lock = _object_of_call(node, Lock.acquire) if node.kernel.waits_for_ever(node) else None
    return lock if isinstance(lock, Lock) else None


@dataclass(frozen=True)
class EndlessWait:
    """A wait that only another node could have ended.

    Args:
        node: the node that waits.
        place: its line, in a file by the name of its module.
        since_s: when it began (s of simulated time).
        holder: who holds the lock that it waits for; None if it waits for something else.
        unheard_s: when a wake-up came that nobody heard (s).
    """

    node: str
    place: str
    since_s: float
    holder: str | None = None
    unheard_s: float | None = None


def find_endless_waits(nodes: Sequence[Node]) -> Iterator[EndlessWait]:
    """The nodes that wait in a lock, an event or the like without a time-out, except idle workers of a pool."""
    for node in nodes:
        waiting = _object_of_call(node, WaitQueue.wait) if node.kernel.waits_for_ever(node) else None
        if isinstance(waiting, WaitQueue) and (place := module_place_of(node.frame)):
            lock = _lock_waited_for(node)
            holder = lock.holder.name if lock is not None and lock.holder is not None else None
            yield EndlessWait(node.name, place, node.blocked_s, holder, waiting.unheard_s)


def find_deadlocks(nodes: Sequence[Node]) -> Iterator[str]:
    """Deadlocks: a sentence for each cycle of nodes that wait for locks of each other.

    A node that waits for a lock that it holds itself is none: another node may release it, as a signal.
    """
    waits = {node: lock for node in nodes if (lock := _lock_waited_for(node)) is not None}
    named: set[Node] = set()
    for node in waits:
        cycle: list[Node] = []
        here: Node | None = node
        while here in waits and here not in cycle and here not in named:
            cycle.append(here)
            here = waits[here].holder
        if here in cycle:
            cycle = cycle[cycle.index(here) :]
            named.update(cycle)
        if here in cycle and len(cycle) > 1:
            yield f"deadlock: {'; '.join(_wait_text(one, waits[one].holder) for one in cycle)}"


def _wait_text(node: Node, holder: Node | None) -> str:
    assert holder is not None
    return f"{node.name} waits at {place_of(node.frame)} for a lock that {holder.name} holds"
