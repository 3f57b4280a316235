"""A waiter on wheels: carries dishes to tables, and takes the empty plates."""

import asyncio
import contextlib
import logging
from collections import deque
from dataclasses import dataclass, field

from .messages import DishReady, GuestWaves, Help, Order, Say, Status, TrayWeight

log = logging.getLogger(__name__)


@dataclass
class Settings:
    speed_m_s: float = 0.5
    table_m: float = 4.0
    take_s: float = 30.0
    spill_g: float = 40.0


@dataclass
class Task:
    table: int
    purpose: str  # "serve" or "clear"
    guests: int = 1


@dataclass
class Waiter:
    incoming: asyncio.Queue
    outgoing: asyncio.Queue
    settings: Settings = field(default_factory=Settings)
    phase: str = "kitchen"

    def __post_init__(self) -> None:
        self.orders: dict[int, Order] = {}
        self.tasks: deque[Task] = deque()
        self.weight = 0.0
        self.loaded = 0.0
        self._something = asyncio.Event()
        self._weighed = asyncio.Event()
        self._halt = asyncio.Event()
        self._handlers = {
            Order: self._order,
            DishReady: self._dish_ready,
            GuestWaves: self._guest_waves,
            TrayWeight: self._tray_weight,
            Help: self._help,
        }

    async def run(self) -> None:
        async with asyncio.TaskGroup() as group:
            group.create_task(self._listen())
            group.create_task(self._work())

    async def _listen(self) -> None:
        while True:
            message = await self.incoming.get()
            handler = self._handlers.get(type(message))
            if handler is None:
                log.warning("ignored: %r", message)
            else:
                await handler(message)

    async def _order(self, order: Order) -> None:
        if order.table in self.orders:
            await self.say(order.table, "one moment please")
            return
        self.orders[order.table] = order
        if order.dish == "soup" and order.guests > 2:
            await self.say(order.table, "the soup comes in two rounds")

    async def _dish_ready(self, ready: DishReady) -> None:
        order = self.orders.pop(ready.table, None)
        if order is None:
            await self.say(0, f"nobody ordered for table {ready.table}")
            return
        self.loaded = ready.weight_g
        self.tasks.append(Task(ready.table, "serve", order.guests))
        self._something.set()

    async def _guest_waves(self, wave: GuestWaves) -> None:
        if wave.hand == "left":
            await self.say(wave.table, "the bill is on its way")
        self.tasks.append(Task(wave.table, "clear"))
        self._something.set()

    async def _tray_weight(self, tray: TrayWeight) -> None:
        self.weight = tray.grams
        self._weighed.set()
        if self.phase == "on the way" and self.weight < self.loaded - self.settings.spill_g:
            self._halt.set()

    async def _help(self, message: Help) -> None:
        if message.text in ("fire", "glass"):
            self._halt.set()

    async def _work(self) -> None:
        while True:
            await self._something.wait()
            self._something.clear()
            while self.tasks:
                task = self.tasks.popleft()
                if await self._go_to(task.table):
                    await (self._serve(task) if task.purpose == "serve" else self._clear(task))
                await self._return()

    async def _go_to(self, table: int) -> bool:
        await self.enter("on the way", table)
        self._halt.clear()
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(self._halt.wait(), self.settings.table_m / self.settings.speed_m_s)
        if self._halt.is_set():
            await self.enter("halted", table)
            await asyncio.sleep(5.0)
            return False
        return True

    async def _serve(self, task: Task) -> None:
        await self.enter("serving", task.table)
        await self.say(task.table, "please take your plate")
        await self._wait_until(lambda: self.weight < self.settings.spill_g)

    async def _clear(self, task: Task) -> None:
        await self.enter("clearing", task.table)
        empty = self.weight
        await self._wait_until(lambda: self.weight > empty + 100)

    async def _wait_until(self, holds) -> None:
        loop = asyncio.get_running_loop()
        end = loop.time() + self.settings.take_s
        while not holds() and loop.time() < end:
            self._weighed.clear()
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._weighed.wait(), end - loop.time())

    async def _return(self) -> None:
        await self.enter("returning")
        await asyncio.sleep(self.settings.table_m / self.settings.speed_m_s)
        await self.enter("kitchen")

    async def say(self, table: int, text: str) -> None:
        await self.outgoing.put(Say(table=table, text=text))

    async def enter(self, phase: str, table: int | None = None) -> None:
        self.phase = phase
        await self.outgoing.put(Status(phase=phase, table=table))
