"""Two guests find that a room has no list yet, and the list of the one replaces that of the other."""

import threading

from messages import Go


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.lock = threading.Lock()
        self.doors = [bus.subscribe(Go), bus.subscribe(Go)]
        self.rooms = {}

    def listen(self, number):
        while True:
            if self.doors[number].wait(100.0) is not None:
                self.serve(number)

    def serve(self, number):
        evening = self.ports.asked
        if evening not in self.rooms:
            guests = {}
            self.rooms[evening] = guests
        self.rooms[evening][number] = True
        self.ports.set("lost", 2 - len(self.rooms[evening]))

    def work(self):
        threading.Thread(target=self.listen, args=(0,), daemon=True).start()
        self.listen(1)


class Repaired(Robot):
    def serve(self, number):
        with self.lock:
            super().serve(number)
