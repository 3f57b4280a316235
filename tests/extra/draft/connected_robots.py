"""Small robots that make a connection themselves, as people write them: source text by name."""

from __future__ import annotations

SERIAL = r"""
import time
import serial

PORT = "/dev/ttyUSB0"


def main():
    ser = serial.Serial(PORT, 115200, timeout=0.5)
    state = "IDLE"
    last = time.time()
    while True:
        line = ser.readline().decode().strip()
        if line == "START" and state == "IDLE":
            state = "RUN"
            ser.write(b"OK RUN\n")
            last = time.time()
        elif line == "STOP":
            state = "IDLE"
            ser.write(b"OK IDLE\n")
        elif line.startswith("SPEED"):
            speed = float(line.split()[1])
            ser.write(f"SPEED {speed}\n".encode())
        elif line:
            ser.write(b"ERR\n")
        if state == "RUN" and time.time() - last > 10.0:
            state = "IDLE"
            ser.write(b"TIMEOUT\n")


if __name__ == "__main__":
    main()
"""

DATAGRAMS = """
import socket
import struct
import time


class Drone:
    def __init__(self, port=8889):
        self.sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.sock.bind(("", port))
        self.sock.settimeout(15.0)
        self.flying = False

    def run(self):
        while True:
            try:
                data, address = self.sock.recvfrom(1024)
            except socket.timeout:
                if self.flying:
                    self.flying = False
                continue
            command = data.decode()
            if command == "takeoff":
                time.sleep(3)
                self.flying = True
                self.sock.sendto(b"ok", address)
            elif command == "land":
                self.flying = False
                self.sock.sendto(b"ok", address)
            else:
                self.sock.sendto(b"error", address)
"""

REPLIES = """
import time
import zmq


class Server:
    def __init__(self):
        self.context = zmq.Context()
        self.socket = self.context.socket(zmq.REP)
        self.socket.bind("tcp://*:5555")
        self.door = "closed"

    def run(self):
        while True:
            message = self.socket.recv_json()
            if message["op"] == "open" and self.door == "closed":
                time.sleep(1)
                self.door = "open"
                self.socket.send_json({"result": "ok", "door": self.door})
            elif message["op"] == "close":
                self.door = "closed"
                self.socket.send_json({"result": "ok", "door": self.door})
            else:
                self.socket.send_json({"result": "refused", "door": self.door})
"""

SELECTED = """
import selectors
import socket

sel = selectors.DefaultSelector()
state = {"light": "off"}


def accept(sock):
    conn, addr = sock.accept()
    conn.setblocking(False)
    sel.register(conn, selectors.EVENT_READ, read)


def read(conn):
    data = conn.recv(1000)
    if not data:
        sel.unregister(conn)
        conn.close()
        return
    word = data.decode().strip()
    if word == "on":
        state["light"] = "on"
        conn.send(b"light on")
    elif word == "off":
        state["light"] = "off"
        conn.send(b"light off")
    else:
        conn.send(b"what")


def main():
    sock = socket.socket()
    sock.bind(("localhost", 1234))
    sock.listen(100)
    sock.setblocking(False)
    sel.register(sock, selectors.EVENT_READ, accept)
    while True:
        for key, mask in sel.select():
            key.data(key.fileobj)


if __name__ == "__main__":
    main()
"""

WEBSOCKET = """
import asyncio
import json
import websockets

state = "idle"


async def handler(websocket):
    global state
    async for message in websocket:
        data = json.loads(message)
        if data["type"] == "start":
            state = "running"
            await websocket.send(json.dumps({"state": state}))
            await asyncio.sleep(2)
            state = "done"
            await websocket.send(json.dumps({"state": state}))
        elif data["type"] == "stop":
            state = "idle"
            await websocket.send(json.dumps({"state": state}))
        else:
            await websocket.send(json.dumps({"error": "unknown type"}))


async def main():
    async with websockets.serve(handler, "localhost", 8765):
        await asyncio.Future()


if __name__ == "__main__":
    asyncio.run(main())
"""

CLIENT_OF_A_CLASS = """
import json
import time
import paho.mqtt.client as mqtt

BROKER = "192.168.1.10"


class Mower:
    def __init__(self):
        self.client = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2)
        self.client.on_connect = self.on_connect
        self.client.on_message = self.on_message
        self.state = "docked"
        self.battery = 100.0

    def on_connect(self, client, userdata, flags, reason_code, properties):
        client.subscribe("mower/cmd")
        client.subscribe("mower/rain")

    def on_message(self, client, userdata, msg):
        if msg.topic == "mower/cmd":
            data = json.loads(msg.payload.decode())
            if data["action"] == "mow" and self.state == "docked":
                self.set_state("mowing")
            elif data["action"] == "dock":
                self.set_state("returning")
        elif msg.topic == "mower/rain":
            if float(msg.payload) > 0.3 and self.state == "mowing":
                self.set_state("returning")

    def set_state(self, state):
        self.state = state
        self.client.publish("mower/state", json.dumps({"state": state, "battery": self.battery}))

    def run(self):
        self.client.connect(BROKER, 1883)
        self.client.loop_start()
        while True:
            time.sleep(1.0)
            if self.state == "mowing":
                self.battery -= 1.0
                if self.battery < 20.0:
                    self.set_state("returning")
            elif self.state == "returning":
                time.sleep(5.0)
                self.set_state("docked")


if __name__ == "__main__":
    Mower().run()
"""

CLIENT_THAT_IS_HANDED_OVER = """
import json
import queue
import time
from enum import Enum

import paho.mqtt.client as mqtt

BROKER = "localhost"
LOADING_TIMEOUT_S = 20.0
STEP_S = 0.5


class Phase(Enum):
    PARKED = "parked"
    LOADING = "loading"
    DRIVING = "driving"
    HANDING = "handing"
    FAULT = "fault"


class Courier:
    def __init__(self, client):
        self.client = client
        self.phase = Phase.PARKED
        self.inbox = queue.Queue()
        self.client.on_message = self.on_message
        self.client.on_connect = self.on_connect

    def on_connect(self, client, userdata, flags, rc, properties=None):
        client.subscribe("courier/#")

    def on_message(self, client, userdata, msg):
        self.inbox.put((msg.topic, json.loads(msg.payload)))

    def say(self, topic, **fields):
        self.client.publish("courier/" + topic, json.dumps(fields))

    def go(self, phase):
        self.phase = phase
        self.say("phase", name=phase.value)

    def wait_for(self, topic, limit_s):
        end = time.monotonic() + limit_s
        while time.monotonic() < end:
            try:
                heard, data = self.inbox.get(timeout=STEP_S)
            except queue.Empty:
                continue
            if heard == "courier/stop":
                raise InterruptedError
            if heard == topic:
                return data
        return None

    def serve(self):
        while True:
            order = self.wait_for("courier/order", 3600.0)
            if order is None:
                continue
            if order["room"] not in ("kitchen", "lab", "office"):
                self.say("refused", room=order["room"])
                continue
            self.go(Phase.LOADING)
            try:
                parcel = self.wait_for("courier/parcel", LOADING_TIMEOUT_S)
                if parcel is None or parcel["weight_kg"] > 5.0:
                    self.go(Phase.FAULT)
                    self.say("gave_up", room=order["room"])
                    time.sleep(2.0)
                else:
                    self.go(Phase.DRIVING)
                    time.sleep(8.0)
                    self.go(Phase.HANDING)
                    self.say("delivered", room=order["room"])
            except InterruptedError:
                self.say("stopped")
            self.go(Phase.PARKED)


def main():
    client = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2)
    courier = Courier(client)
    client.connect(BROKER)
    client.loop_start()
    courier.serve()


if __name__ == "__main__":
    main()
"""
"""It takes orders over MQTT. A stop while it is parked ends it: a fault that the draft finds."""

HANDLERS_OF_A_LIBRARY = """import asyncio
import enum

import socketio

sio = socketio.AsyncClient()
TRAY_LIMIT = 3
SERVE_S = 4.0


class Phase(enum.Enum):
    WAITING = "waiting"
    SERVING = "serving"
    BLOCKED = "blocked"


phase = Phase.WAITING
orders = asyncio.Queue()


async def enter(new):
    global phase
    phase = new
    await sio.emit("phase", {"phase": phase.value, "orders": orders.qsize()})


@sio.event
async def connect():
    await sio.emit("hello", {"robot": "waiter"})


@sio.on("order")
async def on_order(data):
    if orders.qsize() >= TRAY_LIMIT:
        await sio.emit("refused", {"table": data["table"], "reason": "full"})
    else:
        await orders.put(data)


@sio.on("obstacle")
async def on_obstacle(data):
    if data["near"]:
        await enter(Phase.BLOCKED)
    else:
        await enter(Phase.SERVING if not orders.empty() else Phase.WAITING)


async def serve():
    while True:
        order = await orders.get()
        await enter(Phase.SERVING)
        await asyncio.sleep(SERVE_S * order.get("plates", 1))
        if phase is Phase.SERVING:
            await sio.emit("served", {"table": order["table"]})
            await enter(Phase.WAITING)


async def main():
    await sio.connect("http://localhost:5000")
    await serve()


if __name__ == "__main__":
    asyncio.run(main())
"""
"""Events that go by a client that a library makes, and that nobody hands over."""
