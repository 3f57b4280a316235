"""A part is offered to the arm that is first in line, which is sent to rest just then: nobody tells the other arm.

The kind of cpython#112202, there until Python 3.12.
"""

import asyncio
import threading

from messages import Done, Go


class Robot:
    def __init__(self, ports, bus):
        self.bus = bus
        self.rests, self.offers = bus.subscribe(Go), bus.subscribe(Go)
        self.parts = 0

    async def take(self):
        async with self.offered:
            await self.offered.wait_for(lambda: self.parts)
            self.parts -= 1

    async def arm(self):
        while True:
            await self.take()
            self.bus.publish(Done())

    async def offer(self):
        async with self.offered:
            self.parts += 1
            self.offered.notify()

    async def rest(self, arm):
        arm.cancel()

    def listen(self, loop, messages, reaction):
        while messages.wait(100.0) is not None:
            asyncio.run_coroutine_threadsafe(reaction(), loop)

    async def run(self):
        self.offered = asyncio.Condition()
        loop, arms = asyncio.get_running_loop(), [asyncio.create_task(self.arm()) for _ in range(2)]
        for messages, reaction in ((self.rests, lambda: self.rest(arms[0])), (self.offers, self.offer)):
            threading.Thread(target=self.listen, args=(loop, messages, reaction), daemon=True).start()
        await arms[1]

    def work(self):
        asyncio.run(self.run())


class Repaired(Robot):
    async def take(self):
        try:
            await super().take()
        except asyncio.CancelledError:
            async with self.offered:
                self.offered.notify()
            raise
