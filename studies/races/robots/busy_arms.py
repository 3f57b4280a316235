"""Two arms share a table: each waits until it is not busy, and looks at it before it says that it is."""

import asyncio

from messages import Go


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.buttons = [bus.subscribe(Go), bus.subscribe(Go)]
        self.lock = asyncio.Lock()
        self.is_busy = False
        self.pictures = 0

    def look(self):
        self.pictures += 1

    async def reach(self):
        self.ports.begin()
        await asyncio.sleep(0.2)
        self.ports.end()

    async def grasp(self):
        while self.is_busy:
            await asyncio.sleep(0.05)
        await asyncio.to_thread(self.look)
        self.is_busy = True
        await self.reach()
        self.is_busy = False

    async def serve(self, button, debounce_s):
        while True:
            if await asyncio.to_thread(button.wait, 100.0) is not None:
                await asyncio.sleep(debounce_s)
                await self.grasp()

    async def serve_all(self):
        await asyncio.gather(self.serve(self.buttons[0], 0.0), self.serve(self.buttons[1], 0.03))

    def work(self):
        asyncio.run(self.serve_all())


class Repaired(Robot):
    async def grasp(self):
        async with self.lock:
            await super().grasp()
