"""The code under test: coroutines that drive through a door when they are sent.

It has a fault that takes two people: whether the door is open is looked at when it is loaded, and not when it is sent.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from dataclasses import dataclass
from typing import Any, Protocol


@dataclass(frozen=True)
class Loaded:
    """The nurse has put medicine in."""


@dataclass(frozen=True)
class Sent:
    """The nurse sends the robot."""


@dataclass(frozen=True)
class Door:
    """The door has been opened or closed."""

    is_open: bool


@dataclass(frozen=True)
class Seen:
    """Somebody has come into the way, or nobody is there any more."""

    somebody: bool


@dataclass(frozen=True)
class Answered:
    """What the robot does about being sent: "goes" or "refuses"."""

    what: str


class Wheels(Protocol):
    """The drive of the robot."""

    def drive(self, on: bool) -> None: ...

    def is_there(self) -> bool: ...


async def each(subscription: Any) -> AsyncIterator[Any]:
    """The messages of a subscription, as they come: the wait is in a thread, so other coroutines go on."""
    while True:
        message = await asyncio.to_thread(subscription.wait, 1.0)
        if message is not None:
            yield message


class Robot:
    """The robot; with `looks_late` it looks at the door when it is sent, and has no fault."""

    def __init__(self, bus: Any, wheels: Wheels, looks_late: bool) -> None:
        self._bus, self._wheels, self._looks_late = bus, wheels, looks_late
        self._loaded, self._sent = bus.subscribe(Loaded), bus.subscribe(Sent)
        self._door, self._seen = bus.subscribe(Door), bus.subscribe(Seen)
        self._is_open = self._may_go = self._goes = self._is_blocked = False

    async def _watch_door(self) -> None:
        async for message in each(self._door):
            self._is_open = message.is_open

    async def _watch_way(self) -> None:
        async for message in each(self._seen):
            self._is_blocked = message.somebody

    async def _be_loaded(self) -> None:
        async for _ in each(self._loaded):
            self._may_go = self._is_open

    async def _be_sent(self) -> None:
        async for _ in each(self._sent):
            may_go = self._is_open if self._looks_late else self._may_go
            self._goes = self._goes or may_go
            self._bus.publish(Answered("goes" if may_go else "refuses"))

    async def bring(self) -> None:
        """Drive to the other side when it is sent."""
        tasks = [self._watch_door(), self._watch_way(), self._be_loaded(), self._be_sent()]
        listeners = [asyncio.create_task(task) for task in tasks]
        while not self._wheels.is_there():
            self._wheels.drive(self._goes and not self._is_blocked and (self._is_open or not self._looks_late))
            await asyncio.sleep(0.1)
        for listener in listeners:
            listener.cancel()


def bring(bus: Any, wheels: Wheels, looks_late: bool = False) -> None:
    """Bring medicine to the other side."""
    asyncio.run(Robot(bus, wheels, looks_late).bring())
