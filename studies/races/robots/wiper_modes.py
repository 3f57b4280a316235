"""A wiper's timer turns it round at each end, and may write its new direction over a stop that has just come."""

import enum
import threading

from messages import Go, Stop


class Mode(enum.Enum):
    RESTING = "resting"
    LEFT = "left"
    RIGHT = "right"


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.goes, self.stops = bus.subscribe(Go), bus.subscribe(Stop)
        self.lock = threading.Lock()
        self.mode = Mode.RESTING

    def turn(self):
        if self.mode is Mode.LEFT:
            self.ports.move(True)
            self.mode = Mode.RIGHT
        elif self.mode is Mode.RIGHT:
            self.ports.move(True)
            self.mode = Mode.LEFT

    def on_go(self):
        if self.mode is Mode.RESTING:
            self.mode = Mode.LEFT

    def on_stop(self):
        self.mode = Mode.RESTING
        self.ports.move(False)

    def tick(self):
        self.turn()
        timer = threading.Timer(0.2, self.tick)
        timer.daemon = True
        timer.start()

    def watch(self):
        while True:
            if self.stops.wait(100.0) is not None:
                self.on_stop()

    def work(self):
        threading.Thread(target=self.watch, daemon=True).start()
        self.tick()
        while True:
            if self.goes.wait(100.0) is not None:
                self.on_go()


class Repaired(Robot):
    def turn(self):
        with self.lock:
            super().turn()

    def on_go(self):
        with self.lock:
            super().on_go()

    def on_stop(self):
        with self.lock:
            super().on_stop()
