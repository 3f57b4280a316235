"""A watchdog stops the drive after a second without a beat, although a beat has come after it looked."""

import threading
import time

from messages import Go


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.beats = bus.subscribe(Go)
        self.lock = threading.Lock()
        self.last_s = time.monotonic()
        self.tripped = False

    def look(self):
        if not self.tripped and time.monotonic() - self.last_s > 1.0:
            self.tripped = True
            self.ports.move(False)

    def feed(self):
        self.last_s = time.monotonic()
        self.tripped = False
        self.ports.move(True)

    def watch(self):
        while True:
            with self.lock:
                self.look()
            time.sleep(0.1)

    def work(self):
        threading.Thread(target=self.watch, daemon=True).start()
        while True:
            if self.beats.wait(100.0) is not None:
                self.feed()


class Repaired(Robot):
    def feed(self):
        with self.lock:
            super().feed()
