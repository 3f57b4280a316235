"""Small robots that somebody outside calls, as people write them: source text by name."""

from __future__ import annotations

CONDITION = '''
import threading
import time


class Dispenser:
    """Gives out a cup when somebody is there and the tray is free."""

    def __init__(self):
        self._lock = threading.Condition()
        self._stop = threading.Event()
        self._requests = 0
        self.tray_full = False
        self.state = "idle"

    def request_cup(self):
        with self._lock:
            self._requests += 1
            self._lock.notify()

    def tray_changed(self, is_full: bool):
        with self._lock:
            self.tray_full = is_full
            self._lock.notify_all()

    def stop(self):
        self._stop.set()
        with self._lock:
            self._lock.notify_all()

    def run(self):
        while not self._stop.is_set():
            with self._lock:
                while self._requests == 0 and not self._stop.is_set():
                    self._lock.wait(timeout=1.0)
                if self._stop.is_set():
                    break
                self._requests -= 1
            self.state = "filling"
            time.sleep(3.0)
            with self._lock:
                self.state = "waiting"
                if not self._lock.wait_for(lambda: not self.tray_full, timeout=10.0):
                    self.state = "blocked"
                    continue
            self.state = "serving"
            time.sleep(1.0)
            self.state = "idle"
'''

GLOBAL_CLIENT = """
import paho.mqtt.client as mqtt

client = mqtt.Client()
mode = "off"


def on_message(client, userdata, msg):
    global mode
    if msg.payload == b"on":
        mode = "on"
        client.publish("mode", mode)


def main():
    client.on_message = on_message
    client.connect("broker")
    client.subscribe("switch")
    client.loop_forever()


if __name__ == "__main__":
    main()
"""

WEB = """
from flask import Flask, jsonify, request

app = Flask(__name__)
robot = {"state": "idle", "speed": 0.0}


@app.route("/status")
def status():
    return jsonify(robot)


@app.route("/move", methods=["POST"])
def move():
    data = request.get_json()
    speed = float(data.get("speed", 0.0))
    if speed > 1.0:
        return jsonify({"error": "too fast"}), 400
    robot["state"] = "moving" if speed > 0 else "idle"
    robot["speed"] = speed
    return jsonify(robot)


@app.route("/stop", methods=["POST"])
def stop():
    robot["state"] = "stopped"
    robot["speed"] = 0.0
    return jsonify({"ok": True})


if __name__ == "__main__":
    app.run(host="0.0.0.0", port=5000)
"""

EVENTS = """
from statemachine import State, StateMachine


class Barrier(StateMachine):
    closed = State(initial=True)
    opening = State()
    opened = State()
    closing = State()

    request = closed.to(opening)
    up = opening.to(opened)
    passed = opened.to(closing)
    down = closing.to(closed)
    obstacle = closing.to(opening)

    def on_enter_opening(self):
        print("opening")

    def on_enter_closing(self):
        print("closing")
"""

TABLE_OF_METHODS = """
import time


class Robot:
    def __init__(self):
        self.x = 0
        self.gripper = "open"
        self.commands = {
            "forward": self.forward,
            "back": self.back,
            "grip": self.grip,
            "release": self.release,
        }

    def forward(self):
        time.sleep(0.5)
        self.x += 1
        return f"at {self.x}"

    def back(self):
        time.sleep(0.5)
        self.x -= 1
        return f"at {self.x}"

    def grip(self):
        if self.gripper == "closed":
            return "error: already closed"
        self.gripper = "closed"
        return "closed"

    def release(self):
        self.gripper = "open"
        return "open"

    def execute(self, command):
        handler = self.commands.get(command)
        if handler is None:
            return "error: unknown command"
        return handler()
"""

METHODS = '''
import time


class Nurse:
    """Called by the screen."""

    def __init__(self, arm, speaker):
        self.arm = arm
        self.speaker = speaker
        self.state = "idle"
        self.bottle = None

    def fetch(self, bottle: str) -> bool:
        if self.state != "idle":
            self.speaker.say("I am busy")
            return False
        self.state = "fetching"
        time.sleep(2.0)
        if not self.arm.grip():
            self.state = "idle"
            self.speaker.say("I cannot find it")
            return False
        self.bottle = bottle
        self.state = "holding"
        return True

    def hand_over(self) -> bool:
        if self.state != "holding":
            return False
        self.arm.release()
        self.bottle = None
        self.state = "idle"
        return True

    def cancel(self) -> None:
        if self.state == "holding":
            self.arm.release()
        self.state = "idle"
'''

BUTTONS = """
import time
from gpiozero import Button, LED

button = Button(2)
sensor = Button(3)
led = LED(17)
state = "off"


def pressed():
    global state
    if state == "off":
        state = "armed"
        led.blink()
    elif state == "armed":
        state = "off"
        led.off()


def tripped():
    global state
    if state == "armed":
        state = "alarm"
        led.on()


def main():
    button.when_pressed = pressed
    sensor.when_pressed = tripped
    while True:
        time.sleep(0.1)


main()
"""

STEPPED = '''
from enum import Enum


class Mode(Enum):
    SEARCH = 1
    APPROACH = 2
    GRASP = 3
    LIFT = 4


class Picker:
    """Called by a control loop at 10 Hz: step(sensors) -> command."""

    def __init__(self):
        self.mode = Mode.SEARCH
        self.ticks = 0

    def step(self, sensors):
        self.ticks += 1
        if self.mode == Mode.SEARCH:
            if sensors["object_seen"]:
                self.mode = Mode.APPROACH
            return {"v": 0.0, "w": 0.4}
        if self.mode == Mode.APPROACH:
            if sensors["distance"] < 0.15:
                self.mode = Mode.GRASP
                self.ticks = 0
            elif not sensors["object_seen"]:
                self.mode = Mode.SEARCH
            return {"v": 0.2, "w": 0.0}
        if self.mode == Mode.GRASP:
            if self.ticks > 10:
                self.mode = Mode.LIFT if sensors["grip_force"] > 2.0 else Mode.SEARCH
            return {"v": 0.0, "w": 0.0, "grip": 1}
        return {"v": 0.0, "w": 0.0, "lift": 1}
'''

DECORATED = """
import asyncio
from pyee.asyncio import AsyncIOEventEmitter

bus = AsyncIOEventEmitter()
state = "idle"


@bus.on("order")
async def take_order(drink, sugar):
    global state
    if state != "idle":
        bus.emit("refused", drink)
        return
    state = "brewing"
    bus.emit("state", state)
    await asyncio.sleep(4)
    state = "ready"
    bus.emit("state", state)


@bus.on("taken")
async def taken():
    global state
    if state == "ready":
        state = "idle"
        bus.emit("state", state)


async def main():
    await asyncio.Event().wait()
"""

TIMER = """
import threading


class Toaster:
    def __init__(self, heater, display):
        self.heater, self.display = heater, display
        self.state = "empty"
        self._timer = None

    def bread_in(self):
        if self.state == "empty":
            self.state = "toasting"
            self.heater.on()
            self._timer = threading.Timer(90.0, self._done)
            self._timer.start()

    def cancel(self):
        if self._timer is not None:
            self._timer.cancel()
        self._done()

    def _done(self):
        self.heater.off()
        self.state = "done"
        self.display.show("ding")

    def bread_out(self):
        self.state = "empty"
"""

OWN_QUEUE = """
import asyncio
from typing import NamedTuple


class Task(NamedTuple):
    room: int
    item: str


class Courier:
    def __init__(self):
        self.tasks: asyncio.Queue[Task] = asyncio.Queue()
        self.state = "docked"

    async def submit(self, room: int, item: str) -> bool:
        if item not in ("linen", "meal"):
            return False
        await self.tasks.put(Task(room, item))
        return True

    async def run(self):
        while True:
            task = await self.tasks.get()
            self.state = "driving"
            await asyncio.sleep(task.room)
            self.state = "docked"
"""
