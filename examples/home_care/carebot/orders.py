"""The order desk: answers each order at once, and keeps those that wait."""

from __future__ import annotations

import asyncio
from collections import deque
from dataclasses import dataclass

from carebot.bus import Bus
from carebot.config import Config
from carebot.messages import Accepted, Order, Refused
from carebot.tasks import ENDED, TASKS

UNKNOWN, FULL, ENDING = "I cannot do that", "too many orders", "there were to be no more orders"
"""Why an order is refused."""


LATE = "it has taken too long"
"""Why an order is given up that was accepted."""


@dataclass(frozen=True, eq=False)
class Waiting:
    """An order that waits, and when it has to be done, or given up, by the loop's time (s)."""

    kind: str
    due_s: float


class OrderDesk:
    """Takes orders in while others are carried out."""

    def __init__(self, bus: Bus, config: Config) -> None:
        self._bus = bus
        self._config = config
        self._inbox = bus.subscribe(Order)
        self._waiting: deque[Waiting] = deque()
        self._some = asyncio.Event()
        self.busy = False
        """Whether an order is carried out now."""

    async def serve(self) -> None:
        """Answer orders, for as long as the robot works."""
        while True:
            self._answer((await self._inbox.get()).kind)

    @property
    def has_some(self) -> bool:
        """Whether an order waits."""
        return bool(self._waiting)

    @property
    def ends(self) -> bool:
        """Whether nothing waits but the end of orders."""
        return bool(self._waiting) and self._waiting[0].kind == ENDED

    async def some(self) -> None:
        """Wait until an order waits."""
        await self._some.wait()

    def take(self) -> Waiting:
        """The order that has waited for the longest time. Raises IndexError where there is none."""
        return self._removed(self._waiting[0])

    def _removed(self, order: Waiting) -> Waiting:
        self._waiting.remove(order)
        if not self._waiting:
            self._some.clear()
        return order

    def _answer(self, order: str) -> None:
        reason = self._reason_against(order)
        if reason:
            self._bus.publish(Refused(order, reason))
        elif order != ENDED and self.busy and self._config.faults.loses_orders:
            pass  # unreachable: a published fault, which is off
        else:
            self._bus.publish(Accepted(order))
            self._keep(order)

    def _reason_against(self, order: str) -> str:
        """Why the robot will not do it; empty where it will."""
        if order == ENDED:
            return ""
        if order not in TASKS:
            return UNKNOWN
        if any(waiting.kind == ENDED for waiting in self._waiting):
            return ENDING
        return FULL if len(self._waiting) >= self._config.queue else ""

    def _keep(self, kind: str) -> None:
        loop = asyncio.get_running_loop()
        order = Waiting(kind, loop.time() + self._config.order_limit_s)
        self._waiting.append(order)
        self._some.set()
        if kind != ENDED:
            loop.call_at(order.due_s, self._give_up, order)

    def _give_up(self, order: Waiting) -> None:
        """Its time is over: where it still waits, it is not carried out any more."""
        if order in self._waiting:
            self._bus.publish(Refused(self._removed(order).kind, LATE))
