"""Two light barriers count in one number, and each may write over what the other has just counted."""

import threading
import time

from messages import Go


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.lock = threading.Lock()
        self.count = 0
        self.barriers = [bus.subscribe(Go), bus.subscribe(Go)]

    def add(self):
        self.count += 1

    def listen(self, barrier):
        while True:
            if barrier.wait(100.0) is not None:
                self.add()

    def work(self):
        for barrier in self.barriers:
            threading.Thread(target=self.listen, args=(barrier,), daemon=True).start()
        while True:
            self.ports.show(self.count)
            time.sleep(0.2)


class Repaired(Robot):
    def add(self):
        with self.lock:
            super().add()
