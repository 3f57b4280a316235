"""Code that has no classes of messages, as people write it: source text by name."""

from __future__ import annotations

COFFEE = '''
import enum


class Mode(enum.Enum):
    IDLE = "idle"
    BREWING = "brewing"
    ERROR = "error"


class CoffeeMaker:
    """Buttons and a pump."""

    def __init__(self, pump, tank, display):
        self.pump, self.tank, self.display = pump, tank, display
        self.mode = Mode.IDLE
        self._left = 0.0
        pump.on_fault(self._pump_fault)

    def press(self, button):
        if button == "start" and self.mode is Mode.IDLE:
            if self.tank.level_ml() < 100:
                self.mode = Mode.ERROR
                self.display.show("don't forget: refill")
                return False
            self.mode = Mode.BREWING
            self._left = 5.0
            self.pump.on()
        elif button == "stop":
            self.pump.off()
            self.mode = Mode.IDLE
        elif button == "reset" and self.mode is Mode.ERROR:
            self.mode = Mode.IDLE
        return True

    def tick(self, dt):
        if self.mode is Mode.BREWING:
            self._left -= dt
            if self._left <= 0:
                self.pump.off()
                self.display.show("ready")
                self.mode = Mode.IDLE

    def is_ready(self):
        return self.mode is Mode.IDLE

    def _pump_fault(self, code: int):
        self.mode = Mode.ERROR
        self.pump.off()
'''

DEMO = """
from coffee.robot import CoffeeMaker


class Pump:
    def on_fault(self, callback):
        self.callback = callback

    def on(self):
        pass

    def off(self):
        pass


class Tank:
    level = 500.0

    def level_ml(self):
        return self.level


class Display:
    def show(self, text, password="x-1234"):
        pass


def main():
    pump, tank = Pump(), Tank()
    maker = CoffeeMaker(pump, tank, Display())
    maker.press("start")
    for _ in range(60):
        maker.tick(0.1)
    tank.level = 50.0
    maker.press("start")
    pump.callback(3)
    maker.press("reset")


if __name__ == "__main__":
    main()
"""

GUIDE = """
import json
import queue
import time


class Guide:
    def __init__(self, tasks: queue.Queue, client):
        self.tasks, self.client = tasks, client
        self.client.on_message = self.on_message
        self.client.subscribe("museum/stop")
        self.halted = False

    def on_message(self, client, userdata, message):
        data = json.loads(message.payload.decode())
        if message.topic == "museum/stop" and data.get("who") == "guard":
            self.halted = True

    def run(self):
        while True:
            task = self.tasks.get()
            if task["kind"] == "tour" and not self.halted:
                time.sleep(float(task.get("minutes", 5)))
                self.client.publish("museum/done", json.dumps({"kind": "tour"}))
            elif task["kind"] == "home":
                self.client.publish("museum/home", "{}")
"""

PORTER = """
from dataclasses import dataclass


@dataclass(frozen=True)
class Fetch:
    room: int
    kind: str


@dataclass(frozen=True)
class Fetched:
    room: int


class Bus:
    def __init__(self):
        self.callbacks = {}

    def subscribe(self, kind, callback):
        self.callbacks.setdefault(kind, []).append(callback)

    def publish(self, message):
        for callback in self.callbacks.get(type(message), ()):
            callback(message)


class Porter:
    def __init__(self):
        self.bus = Bus()
        self.bus.subscribe(Fetch, self._fetch)

    def _fetch(self, fetch):
        if fetch.kind == "linen":
            self.bus.publish(Fetched(fetch.room))
        elif fetch.kind == "jam":
            raise RuntimeError("the cart is jammed")
"""

DISPENSER = """
import queue
import threading
from typing import NamedTuple


class Fill(NamedTuple):
    cups: int


class Empty(NamedTuple):
    pass


class Dispenser(threading.Thread):
    def __init__(self, pump):
        super().__init__()
        self._box = queue.Queue()
        self._pump = pump

    def post(self, command):
        self._box.put(command)

    def run(self):
        while True:
            self._obey(self._box.get())

    def _obey(self, command):
        match command:
            case Fill(cups=cups):
                self._pump.turn(cups)
            case Empty():
                self._pump.reverse()
"""

SCALE = """
import socket


class Scale:
    def __init__(self):
        self.state = "off"

    def command(self, line):
        verb, _, rest = line.strip().partition(" ")
        if verb == "TARE":
            self.state = "empty"
        elif verb == "LOAD" and float(rest) > 5.0:
            self.state = "full"


def main():
    scale, link = Scale(), socket.socket()
    while True:
        scale.command(link.recv(100).decode())


if __name__ == "__main__":
    main()
"""

LOCKER = """
import json
import time


class Locker:
    def __init__(self, client):
        self.client, self.state = client, "shut"
        for topic, handler in {"order": self.on_order, "keypad": self.on_keypad}.items():
            client.message_callback_add("locker/" + topic, self.wrap(handler))

    def wrap(self, handler):
        return lambda client, userdata, message: handler(**json.loads(message.payload))

    def on_order(self, parcel, urgent):
        self.parcel = parcel
        self.client.publish("locker/now" if urgent else "locker/soon", parcel)

    def on_keypad(self, digits):
        self.state = "open" if digits == "4711" else "shut"

    def loop(self):
        while True:
            time.sleep(0.5)
"""

PRESS = """
import queue
import threading


def worker(events, out):
    while True:
        name, strokes = events.get()
        if name == "start":
            out.put(("pressed", strokes * 2))
        elif name == "quit":
            break


def main():
    events, out = queue.Queue(), queue.Queue()
    threading.Thread(target=worker, args=(events, out)).start()


if __name__ == "__main__":
    main()
"""

PICKER = """
import asyncio
from dataclasses import dataclass


@dataclass
class Pick:
    drug: str


@dataclass
class Picked:
    drug: str


class Picker:
    def __init__(self, incoming: "asyncio.Queue[Pick]", outgoing: "asyncio.Queue[Picked]", stock=None):
        self.incoming, self.outgoing, self.stock = incoming, outgoing, stock or {}

    async def run(self):
        while True:
            pick = await self.incoming.get()
            if self.stock.get(pick.drug, 1) > 0:
                await self.outgoing.put(Picked(pick.drug))


async def serve():
    incoming, outgoing = asyncio.Queue(), asyncio.Queue()

    async def client(reader, writer):
        await incoming.put(Pick((await reader.readline()).decode()))
        writer.write((await outgoing.get()).drug.encode())

    asyncio.create_task(Picker(incoming, outgoing).run())
    await asyncio.start_server(client, "127.0.0.1", 7700)
"""

BELL = """
class Bell:
    def __init__(self, emitter, wheels):
        self.state = "waiting"

        @emitter.on("ring")
        def ring(table):
            self.state = "driving"
            wheels.drive(table)

        @emitter.on("arrived")
        def arrived():
            self.state = "waiting"
            wheels.stop()
"""

OVEN = """
import json
import time


class Oven:
    def __init__(self, panel, coil):
        self.panel, self.coil = panel, coil

    def run(self):
        while True:
            line = self.panel.read()
            if line:
                self.obey(json.loads(line))
            time.sleep(0.1)

    def obey(self, data):
        if data["do"] == "heat":
            self.coil.on(data["degrees"])
        elif data["do"] == "stop":
            self.coil.off()
"""
