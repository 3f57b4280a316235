"""A drive that speeds up writes its speed back, over the 0 of an emergency stop that came while it reckoned."""

import threading
import time

from messages import Stop


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.stops = bus.subscribe(Stop)
        self.lock = threading.Lock()
        self.enabled = True
        self.speed = 0.0

    def accelerate(self):
        speed = min(self.speed + 0.1, 0.5) if self.enabled else self.speed
        self.speed = speed
        self.ports.move(speed > 0.0)

    def stop(self):
        self.enabled = False
        self.speed = 0.0
        self.ports.move(False)

    def watch(self):
        while True:
            if self.stops.wait(100.0) is not None:
                with self.lock:
                    self.stop()

    def work(self):
        threading.Thread(target=self.watch, daemon=True).start()
        while True:
            self.accelerate()
            time.sleep(0.1)


class Repaired(Robot):
    def accelerate(self):
        with self.lock:
            super().accelerate()
