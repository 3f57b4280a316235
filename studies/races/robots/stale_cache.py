"""A drive keeps whether its way is free, and may keep what it found before the way was blocked."""

import threading
import time

from messages import Stop


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.stops = bus.subscribe(Stop)
        self.lock = threading.Lock()
        self.blocked = False
        self.cached = None

    def is_free(self):
        if self.cached is None:
            found = not self.blocked
            self.cached = found
        return self.cached

    def block(self):
        self.blocked = True
        self.cached = None

    def forget(self):
        """Look anew each time, until the way is blocked."""
        if not self.blocked:
            self.cached = None

    def watch(self):
        while True:
            if self.stops.wait(100.0) is not None:
                self.block()

    def work(self):
        threading.Thread(target=self.watch, daemon=True).start()
        while True:
            self.ports.move(self.is_free())
            time.sleep(0.1)
            self.forget()


class Repaired(Robot):
    def is_free(self):
        with self.lock:
            return super().is_free()

    def block(self):
        with self.lock:
            super().block()

    def forget(self):
        with self.lock:
            super().forget()
