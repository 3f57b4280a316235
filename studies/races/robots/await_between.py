"""A task looks whether it may move, awaits a plan made in a thread, and moves, although a stop has come since."""

import asyncio

from messages import Stop


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.stops = bus.subscribe(Stop)
        self.stopped = False
        self.steps = 0

    def plan(self):
        self.steps += 1

    async def step(self):
        if not self.stopped:
            await asyncio.to_thread(self.plan)
            self.ports.move(True)

    async def watch(self):
        while True:
            if await asyncio.to_thread(self.stops.wait, 100.0) is not None:
                self.stopped = True
                self.ports.move(False)

    async def drive(self):
        watching = asyncio.create_task(self.watch())
        while not watching.done():
            await self.step()
            await asyncio.sleep(0.1)

    def work(self):
        asyncio.run(self.drive())


class Repaired(Robot):
    async def step(self):
        await asyncio.to_thread(self.plan)
        if not self.stopped:
            self.ports.move(True)
