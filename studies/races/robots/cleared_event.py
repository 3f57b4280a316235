"""A server clears the event after it has read the orders: one that comes in between waits for the next."""

import threading

from messages import Done, Go


class Robot:
    def __init__(self, ports, bus):
        self.bus = bus
        self.doors = [bus.subscribe(Go), bus.subscribe(Go)]
        self.lock, self.asked, self.orders = threading.Lock(), threading.Event(), 0

    def listen(self, goes):
        while goes.wait(100.0) is not None:
            with self.lock:
                self.orders += 1
            self.asked.set()

    def take(self):
        with self.lock:
            taken, self.orders = self.orders, 0
        self.asked.clear()
        return taken

    def work(self):
        for goes in self.doors:
            threading.Thread(target=self.listen, args=(goes,), daemon=True).start()
        while self.asked.wait():
            for _ in range(self.take()):
                self.bus.publish(Done())


class Repaired(Robot):
    def take(self):
        self.asked.clear()
        with self.lock:
            taken, self.orders = self.orders, 0
        return taken
