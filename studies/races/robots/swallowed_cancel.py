"""A stop cancels the drive while it awaits a tick; `wait_for` of Python 3.11 drops it where a tick came just before.

The kind of cpython#86296 (bpo-42130).
"""

import asyncio
import threading

from messages import Stop


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.brakes, self.encoder = bus.subscribe(Stop), bus.subscribe(Stop)

    async def tick(self):
        await asyncio.wait_for(self.ticks.get(), 0.3)

    async def drive(self):
        try:
            while True:
                self.ports.move(True)
                try:
                    await self.tick()
                except TimeoutError:
                    self.ticks.put_nowait("none")
        finally:
            self.ports.move(False)

    def brake(self, loop, drive):
        if self.brakes.wait(100.0) is not None:
            loop.call_soon_threadsafe(drive.cancel)

    def turn(self, loop):
        """The wheel jerks when the brakes close: a tick."""
        if self.encoder.wait(100.0) is not None:
            loop.call_soon_threadsafe(self.ticks.put_nowait, "tick")

    async def run(self):
        self.ticks = asyncio.Queue()
        loop, drive = asyncio.get_running_loop(), asyncio.create_task(self.drive())
        for target, arguments in ((self.brake, (loop, drive)), (self.turn, (loop,))):
            threading.Thread(target=target, args=arguments, daemon=True).start()
        await asyncio.wait([drive])
        await asyncio.sleep(100.0)

    def work(self):
        asyncio.run(self.run())


class Repaired(Robot):
    async def tick(self):
        async with asyncio.timeout(0.3):
            await self.ticks.get()
