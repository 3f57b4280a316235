"""A worker empties its queue and then clears the event, also that of an order from another hatch since."""

import queue
import threading

from messages import Done, Go


class Robot:
    def __init__(self, ports, bus):
        self.bus = bus
        self.hatches = [bus.subscribe(Go), bus.subscribe(Go)]
        self.orders = queue.Queue()
        self.new = threading.Event()

    def take(self, hatch):
        while True:
            if hatch.wait(100.0) is not None:
                self.orders.put("cup")
                self.new.set()

    def empty(self):
        while not self.orders.empty():
            self.orders.get()
            self.bus.publish(Done())

    def serve(self):
        self.new.wait()
        self.empty()
        self.new.clear()

    def work(self):
        for hatch in self.hatches:
            threading.Thread(target=self.take, args=(hatch,), daemon=True).start()
        while True:
            self.serve()


class Repaired(Robot):
    def serve(self):
        self.new.wait()
        self.new.clear()
        self.empty()
