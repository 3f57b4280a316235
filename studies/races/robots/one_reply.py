"""Two callers share the line to a gripper and one place for the awaited reply, which the later of them takes over."""

import asyncio
from collections import deque

from messages import Done, Go


class Robot:
    def __init__(self, ports, bus):
        self.bus = bus
        self.buttons = [bus.subscribe(Go), bus.subscribe(Go)]
        self.replies = deque(maxlen=1)
        self.line = asyncio.Queue()

    async def ask(self):
        reply = asyncio.get_running_loop().create_future()
        self.replies.append(reply)
        self.line.put_nowait("close")
        await reply

    async def answer(self):
        while True:
            order = await self.line.get()
            await asyncio.sleep(0.01)
            if self.replies:
                self.replies.popleft().set_result(order)

    async def serve(self, button, debounce_s):
        while await asyncio.to_thread(button.wait, 100.0) is not None:
            await asyncio.sleep(debounce_s)
            await self.ask()
            self.bus.publish(Done())

    async def serve_all(self):
        await asyncio.gather(self.answer(), self.serve(self.buttons[0], 0.0), self.serve(self.buttons[1], 0.03))

    def work(self):
        asyncio.run(self.serve_all())


class Repaired(Robot):
    def __init__(self, ports, bus):
        super().__init__(ports, bus)
        self.replies = deque()
