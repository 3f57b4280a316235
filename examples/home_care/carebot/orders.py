"""The order desk: answers each order at once, and keeps those that wait."""

from __future__ import annotations

import asyncio

from carebot.bus import Bus
from carebot.config import Config
from carebot.messages import Accepted, Order, Refused
from carebot.tasks import ENDED, TASKS


class OrderDesk:
    """Takes orders in while others are carried out."""

    def __init__(self, bus: Bus, config: Config) -> None:
        self._bus = bus
        self._config = config
        self._inbox = bus.subscribe(Order)
        self._waiting: asyncio.Queue[str] = asyncio.Queue()
        self._has_served = False
        self.busy = False
        """Whether an order is carried out now."""

    async def serve(self) -> None:
        """Answer orders, for as long as the robot works."""
        while True:
            order = await self._inbox.get()
            if order is not None:
                self._answer(order.kind)

    async def following(self) -> str | None:
        """The next order that waits; None if none comes until the robot is idle."""
        faulty = self._config.faults.never_idle_first and not self._has_served
        try:
            async with asyncio.timeout(None if faulty else self._config.idle_after_s):
                order = await self._waiting.get()
        except TimeoutError:
            return None
        self._has_served = True
        return order

    def _answer(self, order: str) -> None:
        if order not in TASKS and order != ENDED:
            self._bus.publish(Refused(order, "I cannot do that"))
        elif self._config.faults.loses_orders and self.busy:
            pass
        elif self._waiting.qsize() >= self._config.queue:
            self._bus.publish(Refused(order, "too many orders"))
        else:
            self._bus.publish(Accepted(order))
            self._waiting.put_nowait(order)
