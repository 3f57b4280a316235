"""`Timeouts`: the queue from which the `Kernel` takes nodes whose waits time out, in the order of their due times."""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from typing import Generic, Protocol, TypeVar

PRUNE_AT = 1024
"""Number of entries from which ended waits are removed; fewer take some 100 kB (asyncio prunes from 100 timers on)."""


class Waiter(Protocol):
    """An object that waits repeatedly."""

    wait: int
    """The number of its current wait: what was kept of an earlier one is stale."""
    ended: bool


W = TypeVar("W", bound=Waiter)


class Timeouts(Generic[W]):
    """A heap of time-outs. Those of waits that have ended are skipped: their node was woken before."""

    def __init__(self) -> None:
        self._due: list[tuple[int, int, W, int]] = []
        self._order = 0
        self._prune_at = PRUNE_AT

    def add(self, due_us: int, node: W) -> None:
        """Let the wait of a node end at this time at the latest."""
        self._order += 1
        heapq.heappush(self._due, (due_us, self._order, node, node.wait))
        if len(self._due) > self._prune_at:
            self._prune()

    def next_us(self) -> int | None:
        """When the next wait ends (us); None if none has a time-out."""
        while self._due and not _is_pending(self._due[0][2], self._due[0][3]):
            heapq.heappop(self._due)
        return self._due[0][0] if self._due else None

    def pop(self, now_us: int) -> Iterator[W]:
        """The nodes whose waits end by now, in the order in which they are due, then in which they began to wait."""
        while self._due and self._due[0][0] <= now_us:
            _, _, node, wait = heapq.heappop(self._due)
            if _is_pending(node, wait):
                yield node

    def open_timeouts(self) -> Iterator[tuple[int, W]]:
        """When each wait ends (us), in no order."""
        return ((due_us, node) for due_us, _, node, wait in self._due if _is_pending(node, wait))

    def __len__(self) -> int:
        """How many are kept, those of waits that have ended among them."""
        return len(self._due)

    def _prune(self) -> None:
        """Forget time-outs of waits that have ended before: what waits an hour at most, and is woken each millisecond,
        would leave millions. Only once there are twice as many as were needed last, so it costs little for each."""
        self._due = [entry for entry in self._due if _is_pending(entry[2], entry[3])]
        heapq.heapify(self._due)
        self._prune_at = max(PRUNE_AT, 2 * len(self._due))


def _is_pending(node: Waiter, wait: int) -> bool:
    return wait == node.wait and not node.ended
