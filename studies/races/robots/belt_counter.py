"""Two light barriers of a belt count in one number, which each of them reads before and writes after it flashes."""

import asyncio

from messages import Go

FROM_FIRST_TO_SECOND_S = 0.03


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.barriers = [bus.subscribe(Go), bus.subscribe(Go)]
        self.lock = asyncio.Lock()
        self.count = 0

    async def flash(self):
        await asyncio.sleep(0.01)

    async def add(self):
        async with self.lock:
            count = self.count
        await self.flash()
        async with self.lock:
            self.count = count + 1

    async def listen(self, barrier, after_s):
        while True:
            if await asyncio.to_thread(barrier.wait, 100.0) is not None:
                await asyncio.sleep(after_s)
                await self.add()

    async def count_all(self):
        first = asyncio.create_task(self.listen(self.barriers[0], 0.0))
        second = asyncio.create_task(self.listen(self.barriers[1], FROM_FIRST_TO_SECOND_S))
        while not first.done() and not second.done():
            self.ports.show(self.count)
            await asyncio.sleep(0.2)

    def work(self):
        asyncio.run(self.count_all())


class Repaired(Robot):
    async def add(self):
        async with self.lock:
            count = self.count
            await self.flash()
            self.count = count + 1
