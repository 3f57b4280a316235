"""Two threads see one ticket in the drawer, and both take it out."""

import threading

from messages import Go


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.lock = threading.Lock()
        self.doors = [bus.subscribe(Go), bus.subscribe(Go)]
        self.drawer = {}

    def listen(self, number):
        while True:
            if self.doors[number].wait(100.0) is not None:
                self.serve(number)

    def serve(self, number):
        evening = self.ports.asked
        self.drawer.setdefault(evening, ["ticket"])
        if self.drawer[evening]:
            self.drawer[evening].pop()

    def work(self):
        threading.Thread(target=self.listen, args=(0,), daemon=True).start()
        self.listen(1)


class Repaired(Robot):
    def serve(self, number):
        with self.lock:
            super().serve(number)
