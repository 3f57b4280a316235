"""A batch is said to be done once belt and tray are empty, although a part may be in a hand, between the two."""

import queue
import threading
import time

from messages import Done, Go


class Robot:
    def __init__(self, ports, bus):
        self.ports, self.bus, self.goes = ports, bus, bus.subscribe(Go)
        self.belt, self.tray = queue.Queue(), queue.Queue()

    def sort(self):
        while True:
            part = self.belt.get()
            self.tray.put(part)

    def give(self):
        while True:
            self.tray.get()
            self.ports.give()
            self.belt.task_done()

    def finish(self):
        while not (self.belt.empty() and self.tray.empty()):
            time.sleep(0.02)

    def work(self):
        for target in (self.sort, self.give):
            threading.Thread(target=target, daemon=True).start()
        while self.goes.wait(100.0) is not None:
            self.belt.put("cup")
            self.belt.put("saucer")
            self.finish()
            self.bus.publish(Done())


class Repaired(Robot):
    def finish(self):
        self.belt.join()
