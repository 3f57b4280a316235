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
        self.mode, self.token = Mode.IDLE, "x-5678"
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
