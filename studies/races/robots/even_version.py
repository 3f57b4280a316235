"""A pose is read whole where its version is even, as it is, too, while two cameras write the pose at once."""

import threading
import time

from messages import Go


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.cameras = [bus.subscribe(Go), bus.subscribe(Go)]
        self.lock = threading.Lock()
        self.version, self.x, self.y = 0, 0, 0

    def write(self, number):
        self.version += 1
        self.x = number
        self.y = number
        self.version += 1

    def read(self):
        while True:
            version = self.version
            x = self.x
            y = self.y
            if version % 2 == 0 and version == self.version:
                return x, y
            time.sleep(0.01)

    def look(self, goes):
        number = 0
        while goes.wait(100.0) is not None:
            number += 1
            self.write(number)

    def work(self):
        for goes in self.cameras:
            threading.Thread(target=self.look, args=(goes,), daemon=True).start()
        while True:
            x, y = self.read()
            self.ports.set("lost", x - y)
            time.sleep(0.04)


class Repaired(Robot):
    def write(self, number):
        with self.lock:
            super().write(number)
