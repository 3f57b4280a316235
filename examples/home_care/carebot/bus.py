"""A small bus within one event loop: whoever publishes goes on, whoever subscribes awaits."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any, Generic, TypeVar

M = TypeVar("M")


class Inbox(Generic[M]):
    """The messages of one kind since it was made, in their order."""

    def __init__(self) -> None:
        self._queue: asyncio.Queue[M] = asyncio.Queue()

    def put(self, message: M) -> None:
        """Add a message; called by the bus."""
        self._queue.put_nowait(message)

    async def get(self) -> M:
        """The oldest message that was not taken yet; waits for one where there is none."""
        return await self._queue.get()


class Bus:
    """Hands each message to all inboxes of its class, and to all listeners.

    On the robot, a bridge to its middleware publishes what comes in, and listens for what goes out. Not safe for
    threads: a bridge with a thread of its own calls `loop.call_soon_threadsafe(bus.publish, message)`.
    """

    def __init__(self) -> None:
        self._inboxes: dict[type[Any], list[Inbox[Any]]] = {}
        self._listeners: list[Callable[[object], None]] = []

    def subscribe(self, kind: type[M]) -> Inbox[M]:
        """A new inbox for messages of this class."""
        inbox: Inbox[M] = Inbox()
        self._inboxes.setdefault(kind, []).append(inbox)
        return inbox

    def listen(self, listener: Callable[[object], None]) -> None:
        """Call `listener` with each message, of whatever class, when it is published."""
        self._listeners.append(listener)

    def publish(self, message: object) -> None:
        """Hand a message on; never blocks."""
        for inbox in self._inboxes.get(type(message), ()):
            inbox.put(message)
        for listener in self._listeners:
            listener(message)
