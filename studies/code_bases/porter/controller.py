"""The porter's controller: a machine of `transitions`, fed from a queue, with a timer for each phase that may last."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable
from typing import Any

from transitions.extensions.asyncio import AsyncMachine

from .messages import Lid, Obstacle, Phase, Pin, Request, Spoken, Status

log = logging.getLogger("porter")

LOAD_TIMEOUT_S = 40.0
PIN_TIMEOUT_S = 30.0
UNLOAD_TIMEOUT_S = 25.0
SECONDS_PER_ROOM_S = 4.0
CLEAR_M = 0.8
STOP_M = 0.4
PIN_ATTEMPTS = 3


class Porter:
    """Carries one parcel at a time.

    Args:
        inbox: requests, digits, the lid and the front sensor.
        outbox: status and speech.
        pin: that opens the box.
        rooms: the number of the last room.
    """

    TRANSITIONS = [  # noqa: RUF012
        {"trigger": "start_loading", "source": Phase.PARKED, "dest": Phase.LOADING},
        {"trigger": "lid_closed", "source": Phase.LOADING, "dest": Phase.DRIVING, "conditions": "has_room"},
        {"trigger": "obstructed", "source": Phase.DRIVING, "dest": Phase.BLOCKED},
        {"trigger": "cleared", "source": Phase.BLOCKED, "dest": Phase.DRIVING},
        {"trigger": "arrived", "source": Phase.DRIVING, "dest": Phase.WAITING},
        {"trigger": "pin_accepted", "source": Phase.WAITING, "dest": Phase.UNLOADING},
        {"trigger": "lid_closed", "source": Phase.UNLOADING, "dest": Phase.RETURNING},
        {"trigger": "timed_out", "source": Phase.LOADING, "dest": Phase.PARKED},
        {"trigger": "timed_out", "source": [Phase.WAITING, Phase.UNLOADING], "dest": Phase.RETURNING},
        {"trigger": "abort", "source": [Phase.DRIVING, Phase.BLOCKED, Phase.WAITING], "dest": Phase.RETURNING},
        {"trigger": "abort", "source": Phase.LOADING, "dest": Phase.PARKED},
        {"trigger": "home", "source": Phase.RETURNING, "dest": Phase.PARKED},
    ]

    def __init__(self, inbox: asyncio.Queue, outbox: asyncio.Queue, pin: str = "4711", rooms: int = 9) -> None:
        self.inbox = inbox
        self.outbox = outbox
        self.pin = pin
        self.rooms = rooms
        self.room = 0
        self.position = 0
        self.attempts = 0
        self._task: asyncio.Task | None = None
        self.machine = AsyncMachine(
            model=self,
            states=Phase,
            transitions=self.TRANSITIONS,
            initial=Phase.PARKED,
            ignore_invalid_triggers=True,
            after_state_change="report",
        )

    # --- main loop

    async def run(self) -> None:
        """Handle messages until cancelled."""
        await self.report()
        while True:
            message = await self.inbox.get()
            try:
                await self.handle(message)
            except ValueError as error:
                log.warning("ignored %s: %s", message, error)

    async def handle(self, message: Any) -> None:
        """One message."""
        if isinstance(message, Request):
            await self._requested(message)
        elif isinstance(message, Pin):
            await self._typed(message.digits)
        elif isinstance(message, Lid):
            if message.closed:
                await self.lid_closed()
        elif isinstance(message, Obstacle):
            if message.distance_m < STOP_M:
                await self.obstructed()
            elif message.distance_m > CLEAR_M:
                await self.cleared()
        else:
            raise ValueError(f"unknown message {message!r}")

    async def _requested(self, request: Request) -> None:
        if request.kind == "load":
            await self.start_loading()
        elif request.kind == "send":
            if not 1 <= request.room <= self.rooms:
                await self.say("no such room")
                return
            self.room = request.room
            await self.say("please close the lid")
        elif request.kind == "abort":
            await self.abort()
        elif request.kind == "where":
            await self.report()
        else:
            raise ValueError(f"unknown request {request.kind!r}")

    async def _typed(self, digits: str) -> None:
        if self.state is not Phase.WAITING:
            return
        if digits == self.pin:
            await self.pin_accepted()
            return
        self.attempts += 1
        if self.attempts >= PIN_ATTEMPTS:
            await self.say("too many attempts")
            await self.abort()
        else:
            await self.say("wrong pin")

    # --- conditions and callbacks of the machine

    def has_room(self) -> bool:
        """Whether somebody said where to go."""
        return self.room > 0

    async def report(self) -> None:
        """After each change."""
        await self.outbox.put(Status(self.state.value, self.room))

    async def on_enter_LOADING(self) -> None:  # noqa: N802
        self.room = 0
        await self.say("put the parcel in")
        self._begin(self._after(LOAD_TIMEOUT_S, self.timed_out))

    async def on_enter_DRIVING(self) -> None:  # noqa: N802
        self._begin(self._drive(self.room, self.arrived))

    async def on_enter_BLOCKED(self) -> None:  # noqa: N802
        self._stop()
        await self.say("excuse me")

    async def on_enter_WAITING(self) -> None:  # noqa: N802
        self.attempts = 0
        await self.say("please type the pin")
        self._begin(self._after(PIN_TIMEOUT_S, self.timed_out))

    async def on_enter_UNLOADING(self) -> None:  # noqa: N802
        await self.say("take the parcel out")
        self._begin(self._after(UNLOAD_TIMEOUT_S, self.timed_out))

    async def on_enter_RETURNING(self) -> None:  # noqa: N802
        await self.say("goodbye")
        self._begin(self._drive(0, self.home))

    async def on_enter_PARKED(self) -> None:  # noqa: N802
        self._stop()
        self.room = 0

    # --- tasks

    async def _drive(self, room: int, then: Callable[[], Awaitable[bool]]) -> None:
        while self.position != room:
            await asyncio.sleep(SECONDS_PER_ROOM_S)
            self.position += 1 if room > self.position else -1
        self._task = None
        await then()

    async def _after(self, seconds: float, then: Callable[[], Awaitable[bool]]) -> None:
        await asyncio.sleep(seconds)
        self._task = None
        await then()

    def _begin(self, work: Any) -> None:
        self._stop()
        self._task = asyncio.create_task(work)

    def _stop(self) -> None:
        if self._task is not None:
            self._task.cancel()
            self._task = None

    async def say(self, text: str) -> None:
        """Through the loudspeaker."""
        await self.outbox.put(Spoken(text))
