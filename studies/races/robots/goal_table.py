"""A controller looks whether there is a goal for the arm, and fails where a stop takes it away before it is read."""

import threading
import time

from messages import Go, Stop


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.goes, self.stops = bus.subscribe(Go), bus.subscribe(Stop)
        self.lock = threading.Lock()
        self.goals = {}

    def control(self):
        if "arm" in self.goals:
            speed = self.goals["arm"]
            self.ports.move(speed > 0.0)

    def on_go(self):
        self.goals["arm"] = 0.5

    def on_stop(self):
        self.goals.pop("arm", None)
        self.ports.move(False)

    def run_controller(self):
        while True:
            self.control()
            time.sleep(0.1)

    def watch(self):
        while True:
            if self.stops.wait(100.0) is not None:
                self.on_stop()

    def work(self):
        threading.Thread(target=self.run_controller, daemon=True).start()
        threading.Thread(target=self.watch, daemon=True).start()
        while True:
            if self.goes.wait(100.0) is not None:
                self.on_go()


class Repaired(Robot):
    def control(self):
        with self.lock:
            super().control()

    def on_go(self):
        with self.lock:
            super().on_go()

    def on_stop(self):
        with self.lock:
            super().on_stop()
