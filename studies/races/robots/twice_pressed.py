"""Two readers of a bouncing button look at the same time when it was pressed last, and both give a cup."""

import threading
import time

from messages import Go


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.readers = [bus.subscribe(Go), bus.subscribe(Go)]
        self.pressed_s = -1.0

    def press(self):
        now_s = time.monotonic()
        if now_s - self.pressed_s > 0.3:
            self.pressed_s = now_s
            self.ports.give()

    def read(self, goes):
        while goes.wait(100.0) is not None:
            self.press()

    def work(self):
        threads = [threading.Thread(target=self.read, args=(goes,), daemon=True) for goes in self.readers]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()


class Repaired(Robot):
    lock = threading.Lock()

    def press(self):
        with self.lock:
            super().press()
