"""Telepresence rover: a web page drives it over a websocket, and it stops when the page goes silent."""

import asyncio
import json
import logging
import time

log = logging.getLogger(__name__)

SPEEDS = {"slow": 0.2, "normal": 0.5, "fast": 1.0}
SILENCE_S = 0.8


class Rover:
    def __init__(self, motors, bumper):
        self.motors = motors
        self.bumper = bumper
        self.mode = "parked"
        self.pilot = None
        self.speed = SPEEDS["slow"]
        self.clients = set()
        self.last_heard = 0.0

    async def handler(self, websocket, path=None):
        self.clients.add(websocket)
        try:
            await websocket.send(json.dumps({"event": "hello", "mode": self.mode}))
            async for raw in websocket:
                try:
                    message = json.loads(raw)
                except ValueError:
                    await websocket.send(json.dumps({"event": "error", "why": "not JSON"}))
                    continue
                await self.on_message(websocket, message)
        finally:
            self.clients.discard(websocket)
            if self.pilot is websocket:
                await self.release()

    async def on_message(self, websocket, message):
        action = message.get("action")
        self.last_heard = time.monotonic()
        if action == "take":
            if self.pilot is None:
                self.pilot = websocket
                await self.change("piloted")
            else:
                await websocket.send(json.dumps({"event": "busy"}))
        elif action == "drive":
            if self.pilot is not websocket:
                await websocket.send(json.dumps({"event": "error", "why": "not the pilot"}))
                return
            x = max(-1.0, min(1.0, float(message["x"])))
            turn = max(-1.0, min(1.0, float(message.get("turn", 0.0))))
            if self.mode == "blocked" and x > 0:
                return
            self.motors.set(x * self.speed, turn)
        elif action == "speed":
            self.speed = SPEEDS.get(message["level"], self.speed)
        elif action == "release":
            if self.pilot is websocket:
                await self.release()
        elif action == "stop":
            self.motors.stop()
            await self.change("stopped")
        elif action == "ping":
            await websocket.send(json.dumps({"event": "pong"}))
        else:
            log.warning("unknown action %r", action)

    async def release(self):
        self.pilot = None
        self.motors.stop()
        await self.change("parked")

    async def change(self, mode):
        if mode == self.mode:
            return
        self.mode = mode
        text = json.dumps({"event": "mode", "mode": mode})
        await asyncio.gather(*(client.send(text) for client in self.clients), return_exceptions=True)

    async def watch(self):
        while True:
            if self.bumper.pressed() and self.mode == "piloted":
                self.motors.stop()
                await self.change("blocked")
            elif self.mode == "blocked" and not self.bumper.pressed():
                await self.change("piloted")
            if self.mode == "piloted" and time.monotonic() - self.last_heard > SILENCE_S:
                self.motors.stop()
                await self.change("silent")
            elif self.mode == "silent" and time.monotonic() - self.last_heard <= SILENCE_S:
                await self.change("piloted")
            await asyncio.sleep(0.1)


async def main():
    import websockets

    from rover.hardware import Bumper, Motors

    rover = Rover(Motors(), Bumper())
    async with websockets.serve(rover.handler, "0.0.0.0", 8765):
        await rover.watch()


if __name__ == "__main__":
    asyncio.run(main())
