"""One thread reads a pose of which another one has written the first coordinate only."""

import threading

from messages import Go


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.lock = threading.Lock()
        self.doors = [bus.subscribe(Go), bus.subscribe(Go)]
        self.x = self.y = 0
        self.torn = 0

    def listen(self, number):
        while True:
            if self.doors[number].wait(100.0) is not None:
                self.serve(number)

    def serve(self, number):
        if number == 0:
            self.x = self.ports.asked
            self.y = self.ports.asked
        else:
            x = self.x
            self.torn += x != self.y
        self.ports.set("lost", self.torn)

    def work(self):
        threading.Thread(target=self.listen, args=(0,), daemon=True).start()
        self.listen(1)


class Repaired(Robot):
    def serve(self, number):
        with self.lock:
            super().serve(number)
