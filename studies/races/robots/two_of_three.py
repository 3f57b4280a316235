"""Three sensors count who has seen the person, and two suffice: each may write over the count of the one before."""

import threading
import time

from messages import Done, Go


class Robot:
    def __init__(self, ports, bus):
        self.bus, self.goes = bus, bus.subscribe(Go)
        self.sensors = [bus.subscribe(Go) for _ in range(3)]
        self.lock = threading.Lock()
        self.seen = 0

    def count(self):
        self.seen += 1

    def look(self, goes, exposure_s):
        while goes.wait(100.0) is not None:
            time.sleep(exposure_s)
            self.count()

    def work(self):
        for number, goes in enumerate(self.sensors):
            threading.Thread(target=self.look, args=(goes, 0.1 + 0.03 * number), daemon=True).start()
        while self.goes.wait(100.0) is not None:
            time.sleep(0.5)
            if self.seen >= 2:
                self.bus.publish(Done())
            self.seen = 0


class Repaired(Robot):
    def count(self):
        with self.lock:
            self.seen += 1
