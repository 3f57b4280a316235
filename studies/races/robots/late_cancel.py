"""A timer starts the motor a second after a wish. A stop cancels it, but its callback may have begun already."""

import threading

from messages import Go, Stop


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.goes, self.stops = bus.subscribe(Go), bus.subscribe(Stop)
        self.timer = None
        self.wanted = False
        self.lock = threading.Lock()

    def start(self):
        self.timer = None
        self.ports.move(True)

    def on_go(self):
        self.wanted = True
        if self.timer is not None:
            self.timer.cancel()
        self.timer = threading.Timer(1.0, self.start)
        self.timer.start()

    def on_stop(self):
        self.wanted = False
        if self.timer is not None:
            self.timer.cancel()
            self.timer = None
        self.ports.move(False)

    def watch(self):
        while True:
            if self.stops.wait(100.0) is not None:
                with self.lock:
                    self.on_stop()

    def work(self):
        threading.Thread(target=self.watch, daemon=True).start()
        while True:
            if self.goes.wait(100.0) is not None:
                with self.lock:
                    self.on_go()


class Repaired(Robot):
    def start(self):
        with self.lock:
            if self.wanted:
                super().start()
