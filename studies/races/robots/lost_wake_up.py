"""A worker sees that there are no orders, and waits for the next, although one comes before it waits."""

import threading

from messages import Done, Go


class Robot:
    def __init__(self, ports, bus):
        self.bus = bus
        self.hatches = [bus.subscribe(Go), bus.subscribe(Go)]
        self.orders = []
        self.changed = threading.Condition()

    def take(self, hatch):
        while True:
            if hatch.wait(100.0) is not None:
                self.orders.append("cup")
                with self.changed:
                    self.changed.notify()

    def wait(self):
        if not self.orders:
            with self.changed:
                self.changed.wait()

    def work(self):
        for hatch in self.hatches:
            threading.Thread(target=self.take, args=(hatch,), daemon=True).start()
        while True:
            self.wait()
            while self.orders:
                self.orders.pop()
                self.bus.publish(Done())


class Repaired(Robot):
    def wait(self):
        with self.changed:
            while not self.orders:
                self.changed.wait()
