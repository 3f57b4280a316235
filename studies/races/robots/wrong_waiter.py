"""A hand that has left the tray wakes one of those who wait: the other hand, maybe, and not the feeder."""

import queue
import threading

from messages import Done, Go


class Robot:
    def __init__(self, ports, bus):
        self.bus, self.goes = bus, bus.subscribe(Go)
        self.tray, self.places, self.changed = [], 1, threading.Condition()
        self.saucers = queue.Queue()

    def tell(self):
        self.changed.notify()

    def put(self, part):
        with self.changed:
            while not self.places:
                self.changed.wait()
            self.places -= 1
            self.tray.append(part)
            self.tell()

    def serve(self):
        while True:
            with self.changed:
                while not self.tray:
                    self.changed.wait()
                self.tray.pop()
            self.bus.publish(Done())
            with self.changed:
                self.places += 1
                self.tell()

    def feed(self):
        while True:
            self.put(self.saucers.get())

    def work(self):
        for target in (self.serve, self.serve, self.feed):
            threading.Thread(target=target, daemon=True).start()
        while self.goes.wait(100.0) is not None:
            self.put("cup")
            self.saucers.put("saucer")


class Repaired(Robot):
    def tell(self):
        self.changed.notify_all()
