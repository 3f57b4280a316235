"""Drives a rover without hardware, as a page would."""

import asyncio
import json

from rover.server import Rover


class FakeSocket:
    def __init__(self, script):
        self.script = script
        self.sent = []

    async def send(self, text):
        self.sent.append(text)

    def __aiter__(self):
        return self._play()

    async def _play(self):
        for pause, message in self.script:
            await asyncio.sleep(pause)
            yield json.dumps(message)


class FakeMotors:
    def set(self, forward, turn):
        print("drive", forward, turn)

    def stop(self):
        print("stop")


class FakeBumper:
    count = 0

    def pressed(self):
        self.count += 1
        return 8 < self.count < 12


async def main():
    rover = Rover(FakeMotors(), FakeBumper())
    watch = asyncio.ensure_future(rover.watch())
    script = [(0.1, {"action": "ping"}), (0.1, {"action": "take"}), (0.2, {"action": "speed", "level": "fast"}),
              (0.2, {"action": "drive", "x": 0.5, "turn": 0.1}), (0.4, {"action": "drive", "x": -0.5}),
              (1.5, {"action": "stop"}), (0.1, {"action": "release"})]
    socket = FakeSocket(script)
    await rover.handler(socket)
    watch.cancel()
    print(*socket.sent, sep="\n")


if __name__ == "__main__":
    asyncio.run(main())
