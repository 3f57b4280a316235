"""Sets whose order is that of insertion: `rclpy` has sets of nodes, which an executor visits in their order."""

from __future__ import annotations

import sys
from collections.abc import Hashable, Iterable, Iterator, MutableSet
from typing import TypeVar

T = TypeVar("T", bound=Hashable)

_MODULES = ("rclpy.executors", "rclpy.time_source", "rclpy.lifecycle.node")
"""Those that visit sets of what has no order but that of its addresses."""


class OrderedSet(MutableSet[T]):
    """As `set`, in the order of insertion."""

    def __init__(self, items: Iterable[T] = ()) -> None:
        self._items = dict.fromkeys(items)

    def __contains__(self, item: object) -> bool:
        return item in self._items

    def __iter__(self) -> Iterator[T]:
        return iter(self._items)

    def __len__(self) -> int:
        return len(self._items)

    def add(self, value: T) -> None:
        """Add it at the end, unless it is in it."""
        self._items[value] = None

    def discard(self, value: T) -> None:
        """Take it out, if it is in it."""
        self._items.pop(value, None)

    def copy(self) -> OrderedSet[T]:
        """Another one with the same items."""
        return OrderedSet(self._items)


def order_sets_of_rclpy() -> None:
    """Let the modules of `rclpy` that are loaded make ordered sets from now on."""
    for name in _MODULES:
        if name in sys.modules:
            vars(sys.modules[name])["set"] = OrderedSet
