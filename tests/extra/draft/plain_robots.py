"""Small robots whose messages have no class, as people write them: source text by name."""

from __future__ import annotations

TEXTS = """
import queue
import time


def robot(inbox, outbox):
    state = "idle"
    while True:
        try:
            word = inbox.get(timeout=20)
        except queue.Empty:
            outbox.put("sleeping")
            return
        if word == "go" and state == "idle":
            state = "moving"
            outbox.put("moving")
            time.sleep(2.0)
            state = "idle"
            outbox.put("arrived")
        elif word == "stop":
            outbox.put("stopped")
        else:
            outbox.put("what?")
"""

DICTS = """
import asyncio


class Waiter:
    def __init__(self, orders: asyncio.Queue, status: asyncio.Queue):
        self.orders = orders
        self.status = status
        self.state = "waiting"

    async def tell(self, state):
        self.state = state
        await self.status.put({"state": self.state, "load": 0.5})

    async def run(self):
        while True:
            msg = await self.orders.get()
            if msg["kind"] == "order":
                await self.tell("fetching")
                await asyncio.sleep(msg["table"] * 0.5)
                await self.tell("serving")
                await asyncio.sleep(1)
                await self.tell("waiting")
            elif msg["kind"] == "cancel":
                await self.tell("waiting")
"""

TUPLES = """
import queue
import threading
import time

commands = queue.Queue()
status = queue.Queue()


def control_loop():
    while True:
        cmd = commands.get()
        kind, value = cmd
        if kind == "move":
            status.put(("moving", value))
            time.sleep(1.5)
            status.put(("done", value))
        elif kind == "halt":
            status.put(("halted", 0))
            break


if __name__ == "__main__":
    threading.Thread(target=control_loop).start()
    commands.put(("move", 3))
"""

JSON = """
import json
import queue
import time


class Arm:
    def __init__(self):
        self._inbox = queue.Queue()
        self._out = queue.Queue()
        self.state = "parked"

    def send(self, text):
        self._inbox.put(text)

    def read(self):
        return self._out.get()

    def run(self):
        while True:
            try:
                data = json.loads(self._inbox.get(timeout=5.0))
            except queue.Empty:
                continue
            cmd = data.get("cmd")
            if cmd == "pick" and self.state == "parked":
                self.state = "picking"
                self._out.put(json.dumps({"event": "picking", "speed": data.get("speed", 0.2)}))
                time.sleep(1)
                self.state = "holding"
                self._out.put(json.dumps({"event": "holding"}))
            elif cmd == "place" and self.state == "holding":
                self.state = "parked"
                self._out.put(json.dumps({"event": "parked"}))
            else:
                self._out.put(json.dumps({"event": "refused"}))


def main():
    arm = Arm()
    arm.run()


if __name__ == "__main__":
    main()
"""

HELD = '''
import threading
import time


class Gate:
    """A gate with a state that nobody tells."""

    def __init__(self, sensor, motor):
        self.sensor, self.motor = sensor, motor
        self.state = "closed"

    def run(self):
        while True:
            if self.state == "closed" and self.sensor.is_car_there():
                self.state = "opening"
                self.motor.up()
                time.sleep(3.0)
                self.state = "open"
            elif self.state == "open" and not self.sensor.is_car_there():
                self.state = "closing"
                self.motor.down()
                time.sleep(3.0)
                self.state = "closed"
            time.sleep(0.1)
'''

TERMINAL = """
import time


class Butler:
    def __init__(self):
        self.state = "idle"
        self.tea = 0

    def brew(self):
        self.state = "brewing"
        print("brewing tea")
        time.sleep(4.0)
        self.tea += 1
        self.state = "idle"
        print(f"tea number {self.tea} is ready")

    def run(self):
        while True:
            line = input("> ").strip().lower()
            if line == "tea":
                self.brew()
            elif line in ("quit", "exit"):
                print("bye")
                break
            else:
                print("I do not understand")


if __name__ == "__main__":
    Butler().run()
"""

LINES = r"""
import asyncio


async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter):
    position = 0.0
    while True:
        line = await reader.readline()
        if not line:
            break
        parts = line.decode().strip().split()
        if parts[0] == "MOVE":
            await asyncio.sleep(0.5)
            position += float(parts[1])
            writer.write(b"OK\n")
        elif parts[0] == "WHERE":
            writer.write(f"AT {position}\n".encode())
        else:
            writer.write(b"ERR\n")
        await writer.drain()
"""

TOPICS = """
import time


class Vacuum:
    def __init__(self, bus):
        self.bus = bus
        self.state = "docked"
        bus.subscribe("command", self.on_command)
        bus.subscribe("battery", self.on_battery)

    def on_command(self, payload):
        if payload["action"] == "clean" and self.state == "docked":
            self.set_state("cleaning")
        elif payload["action"] == "dock":
            self.set_state("docked")

    def on_battery(self, level):
        if level < 20:
            self.bus.publish("alarm", "battery low")
            self.set_state("docked")

    def set_state(self, state):
        self.state = state
        self.bus.publish("state", {"name": state})

    def run(self):
        while True:
            time.sleep(1.0)
"""

CALLED_BACK = """
import asyncio


class Door:
    def __init__(self, bus):
        self.bus = bus
        bus.on("open", self._open)
        bus.on("speed", lambda value: None)

    async def _open(self, topic, who):
        if who == "guest":
            await self.bus.emit("door", ("opening", who))
            await asyncio.sleep(2.0)
        await self.bus.emit("door", ("open", who))


class Hall:
    def __init__(self, client):
        self.client = client

    def late(self, other):
        other.publish("hall/light", "on")
"""

EVENTS_WITH_KEYWORDS = """import threading
import time

MAX_WEIGHT_KG = 8.0


class Sorter(threading.Thread):
    def __init__(self, bus):
        super().__init__(daemon=True)
        self.bus = bus
        self.mode = "idle"
        self._parcel = None
        self._arrived = threading.Event()
        self._stopped = threading.Event()
        self._steps = {"idle": self._idle, "gripping": self._gripping, "sorting": self._sorting, "halted": self._halted}
        bus.on("parcel", self._on_parcel)
        bus.on("door", self._on_door)
        bus.on("reset", self._on_reset)

    def _on_parcel(self, data):
        if self.mode != "idle":
            self.bus.emit("rejected", reason="busy")
            return
        self._parcel = data
        self._arrived.set()

    def _on_door(self, data):
        if data["open"]:
            self._set("halted")

    def _on_reset(self, data):
        if self.mode == "halted":
            self._set("idle")

    def _set(self, mode):
        if mode != self.mode:
            self.mode = mode
            self.bus.emit("mode", name=mode, at=time.perf_counter())

    def run(self):
        while not self._stopped.is_set():
            self._steps[self.mode]()

    def _idle(self):
        if self._arrived.wait(0.5):
            self._arrived.clear()
            if self._parcel["weight_kg"] > MAX_WEIGHT_KG:
                self.bus.emit("rejected", reason="too heavy")
            else:
                self._set("gripping")

    def _gripping(self):
        time.sleep(1.5)
        if self.mode == "gripping":
            self._set("sorting")

    def _sorting(self):
        lane = {"small": 1, "large": 2}.get(self._parcel["size"], 3)
        time.sleep(5.0)
        self.bus.emit("sorted", lane=lane)
        self._set("idle")

    def _halted(self):
        time.sleep(0.1)

"""
"""Its bus hands on what is said by keywords, as a dict, as keywords or after the event: see `HANDLERS`."""

HANDLERS = {
    "a dict": ("self, data", "data"),
    "keywords": ("self, weight_kg, size", '{"weight_kg": weight_kg, "size": size}'),
    "any keywords": ("self, **data", "data"),
    "the event, and a dict": ("self, event, data", "data"),
    "the sender, and keywords": ("self, _sender, **data", "data"),
}
"""How the bus may call back for a parcel: parameters, and what comes."""

NUMBERED = """import time

IDLE, MOVING, LIFTING, ERROR = range(4)
NAMES = {IDLE: "IDLE", MOVING: "MOVING", LIFTING: "LIFTING", ERROR: "ERROR"}
WATCHDOG_S = 2.0
PERIOD_S = 0.05


class Fork:
    def __init__(self, io, log):
        self.io = io
        self.log = log
        self.state = IDLE
        self.goal = None
        self.last_heartbeat = time.monotonic()

    def step(self):
        for line in self.io.poll_commands():
            name, *args = line.split()
            if name == "HB":
                self.last_heartbeat = time.monotonic()
            elif name == "GOTO" and self.state == IDLE:
                self.goal = float(args[0])
                self.change(MOVING)
            elif name == "LIFT" and self.state == IDLE:
                self.change(LIFTING)
            elif name == "RESET" and self.state == ERROR:
                self.change(IDLE)
            else:
                self.io.reply("NAK " + name)
        if self.state == MOVING:
            error = self.goal - self.io.position()
            if abs(error) < 0.01:
                self.io.set_speed(0.0)
                self.change(IDLE)
            else:
                self.io.set_speed(0.5 if error > 0 else -0.5)
        if self.state != ERROR and time.monotonic() - self.last_heartbeat > WATCHDOG_S:
            self.io.set_speed(0.0)
            self.change(ERROR)

    def change(self, state):
        self.log(f"{NAMES[self.state]} -> {NAMES[state]}")
        self.state = state

    def run(self):
        while True:
            self.step()
            time.sleep(PERIOD_S)
"""
"""Its states are numbers with names."""

INBOXES = """from dataclasses import dataclass
import time


@dataclass
class Light:
    on: bool = False
    count: int = 0


@dataclass
class Switch:
    always: bool = False
    on: bool = True


class Lamp:
    def __init__(self, bus):
        self.bus = bus
        self.inbox = bus.subscribe(Switch)

    def run(self):
        n = 0
        while True:
            heard = self.inbox.get()
            n += 1
            self.bus.publish(Light(on=heard.on and not heard.always, count=n))
            time.sleep(1.0)
"""
"""It takes from what it subscribed to as from a queue; fields have names that are words of requirements."""
