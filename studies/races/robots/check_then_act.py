"""Two hatches give away one cup: both look whether it is there before one of them has taken it."""

import threading

from messages import Go


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.cups = 1
        self.lock = threading.Lock()
        self.wishes = [bus.subscribe(Go), bus.subscribe(Go)]

    def take(self):
        if self.cups > 0:
            self.cups -= 1
            self.ports.give()

    def serve(self, wishes):
        while True:
            if wishes.wait(100.0) is not None:
                self.take()

    def work(self):
        threading.Thread(target=self.serve, args=(self.wishes[0],), daemon=True).start()
        self.serve(self.wishes[1])


class Repaired(Robot):
    def take(self):
        with self.lock:
            super().take()
