"""Stand-ins for the queues and buses of the code under test, connected to the bus of the test.

`BusPort`, `InboxPort` and `OutboxPort` are what the conftest.py of a draft declares (from `pytest_hricdv.draft`); in
each run, `make` creates the stand-in that the code gets: a `CodeBus`, an `Inbox` or an `Outbox`, or its form for
asyncio.
"""

from __future__ import annotations

import asyncio
import queue
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from pytest_hricdv.extra.draft.stand_ins.border import RunBorder
from pytest_hricdv.extra.draft.stand_ins.neutral import REST_OF_RUN_S, Lenient

LOOKS_EACH_S = 0.02
"""Period at which a queue with several topics is polled (s)."""

Convert = Callable[[Any], Any]
"""Converts a message of the test to the object that the code gets."""


def _same(message: Any) -> Any:
    return message


class Inbox(Lenient):
    """A queue that the code takes from: it contains what a person says. What the code itself puts into it is discarded,
    since a person would not know of it."""

    def __init__(self, border: RunBorder, kinds: Mapping[type[Any], Convert]) -> None:
        self._border = border
        self._kernel = border.run.kernel
        self._heard = [(border.run.bus.port("robot").subscribe(kind), convert) for kind, convert in kinds.items()]
        self._next: list[Any] = []

    def _look(self) -> bool:
        for heard, convert in self._heard:
            message = None if self._next else heard.poll()
            if message is not None:
                self._next.append(convert(message))
        return bool(self._next)

    def get(self, block: bool = True, timeout: float | None = None) -> Any:
        """The oldest message; raises queue.Empty like a queue."""
        self._border.on_crossing()
        ends_s = self._kernel.now_s + (REST_OF_RUN_S if timeout is None else timeout) if block else self._kernel.now_s
        while not self._look():
            left_s = ends_s - self._kernel.now_s
            if left_s <= 0.0:
                raise queue.Empty
            if len(self._heard) == 1:
                heard, convert = self._heard[0]
                message = heard.wait(left_s)
                if message is not None:
                    return convert(message)
            else:
                self._kernel.sleep(min(LOOKS_EACH_S, left_s) if self._heard else left_s)
        return self._next.pop(0)

    def get_nowait(self) -> Any:
        """The same without waiting."""
        return self.get(block=False)

    def wait(self, timeout: float | None = None) -> Any:
        """The oldest message; None if there is none in this time."""
        try:
            return self.get(timeout=timeout)
        except queue.Empty:
            return None

    def poll(self) -> Any:
        """The oldest message; None if there is none."""
        return self._next.pop(0) if self._look() else None

    def empty(self) -> bool:
        """Whether it contains no message."""
        return not self._look()

    def qsize(self) -> int:
        """1 if it contains a message, else 0."""
        return int(self._look())


class AsyncInbox(Lenient):
    """An `Inbox` for coroutines."""

    def __init__(self, border: RunBorder, kinds: Mapping[type[Any], Convert]) -> None:
        self._queue: asyncio.Queue[Any] = asyncio.Queue()
        self._loop = asyncio.get_running_loop()
        self._border = border
        for kind, convert in kinds.items():
            heard = border.run.bus.port("robot").subscribe(kind)
            border.run.kernel.spawn(f"robot hears {kind.__name__}", partial(self._hear, heard, convert))

    def _hear(self, heard: Any, convert: Convert) -> None:
        while not self._loop.is_closed():
            message = heard.wait(REST_OF_RUN_S)
            if message is not None and not self._loop.is_closed():
                self._loop.call_soon_threadsafe(self._queue.put_nowait, convert(message))

    async def get(self, *_: Any, **__: Any) -> Any:
        """The oldest message; waits for one if necessary, whatever timeout the code passes."""
        self._border.on_crossing()
        return await self._queue.get()

    def get_nowait(self) -> Any:
        """The same without waiting; raises asyncio.QueueEmpty."""
        return self._queue.get_nowait()

    def poll(self) -> Any:
        """The oldest message; None if there is none."""
        return None if self._queue.empty() else self._queue.get_nowait()

    def empty(self) -> bool:
        """Whether it contains no message."""
        return self._queue.empty()

    def qsize(self) -> int:
        """The number of messages in it."""
        return self._queue.qsize()

    def __aiter__(self) -> AsyncInbox:
        return self

    async def __anext__(self) -> Any:
        return await self.get()


class Outbox(Lenient):
    """A queue, or a function, that the code hands messages to: the robot publishes them."""

    def __init__(self, border: RunBorder, name: str) -> None:
        self._border, self._name = border, name

    def __call__(self, *contents: Any, **_: Any) -> None:
        """Publish the message among the arguments."""
        self._border.note_call(self._name, "put", contents, {})
        self._border.say(self._name, "put", contents)

    put_nowait = put = __call__

    def empty(self) -> bool:
        """True: every message is taken immediately."""
        return True


class AsyncOutbox(Outbox):
    """An `Outbox` for coroutines."""

    async def put(self, *contents: Any) -> None:  # type: ignore[override]
        """Publish the message; never waits."""
        self(*contents)


class CodeBus:
    """A bus whose topics are classes; a subscription is an inbox, or calls a function with each message."""

    def __init__(self, border: RunBorder, name: str) -> None:
        self._border, self._name = border, name

    def publish(self, *contents: Any, **named: Any) -> None:
        """Publish the message among the arguments."""
        every = (*contents, *named.values())
        self._border.note_call(self._name, "publish", every, {})
        self._border.say(self._name, "publish", every)

    def subscribe(self, *arguments: Any, **named: Any) -> Any:
        """An inbox for messages of these classes; a function among the arguments is called with each message."""
        every = (*arguments, *named.values())
        listed = [part for value in every for part in (value if isinstance(value, list | tuple) else [value])]
        kinds = {kind: _same for kind in listed if isinstance(kind, type) and kind in self._border.kinds}
        callback = next((value for value in listed if callable(value) and not isinstance(value, type)), None)
        if self._border.is_async:
            inbox: Any = AsyncInbox(self._border, kinds)
            if callback is not None:
                self._calling = asyncio.ensure_future(_call_async(inbox, callback))
            return inbox
        inbox = Inbox(self._border, kinds)
        if callback is not None and kinds:  # in a node of its own, as the thread of a middleware does
            run = self._border.run
            names = ", ".join(kind.__name__ for kind in kinds)
            run.kernel.spawn(f"robot hears {names}", run.measured(partial(_call, self._border, inbox, callback)))
        return inbox


def _call(border: RunBorder, inbox: Inbox, callback: Callable[[Any], Any]) -> None:
    while True:
        callback(inbox.get())
        border.on_crossing()


async def _call_async(inbox: AsyncInbox, callback: Callable[[Any], Any]) -> None:
    while True:
        made = callback(await inbox.get())
        if asyncio.iscoroutine(made):
            await made


@dataclass(frozen=True)
class BusPort:
    """A bus: an object with `publish` and `subscribe`, whose topics are classes."""

    def make(self, border: RunBorder, name: str) -> Any:
        """The stand-in for one run."""
        return CodeBus(border, name)


@dataclass(frozen=True, init=False)
class InboxPort:
    """A queue that the code takes from.

    Args:
        kinds: the classes of the messages in it; in a dict, each with a function that converts a message to what the
            code takes: `InboxPort({Order: lambda m: {"item": m.item}})`.
    """

    kinds: tuple[tuple[type[Any], Convert], ...]

    def __init__(self, *kinds: type[Any] | dict[type[Any], Convert]) -> None:
        pairs = [pair for kind in kinds for pair in (kind.items() if isinstance(kind, dict) else [(kind, _same)])]
        object.__setattr__(self, "kinds", tuple(pairs))

    def make(self, border: RunBorder, name: str) -> Any:
        """The stand-in for one run."""
        kinds = dict(self.kinds)
        return AsyncInbox(border, kinds) if border.is_async else Inbox(border, kinds)


@dataclass(frozen=True)
class OutboxPort:
    """A queue that the code puts into, or a function that it calls with each message."""

    def make(self, border: RunBorder, name: str) -> Any:
        """The stand-in for one run."""
        return AsyncOutbox(border, name) if border.is_async else Outbox(border, name)
