"""Two clerks move a coin from one purse to the other, and each writes over what the other has written."""

import threading

from messages import Go


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.lock = threading.Lock()
        self.doors = [bus.subscribe(Go), bus.subscribe(Go)]
        self.left, self.right = 50, 50

    def listen(self, number):
        while True:
            if self.doors[number].wait(100.0) is not None:
                self.serve(number)

    def serve(self, number):
        left = self.left
        self.left = left - 1
        right = self.right
        self.right = right + 1
        self.ports.set("lost", 100 - self.left - self.right)

    def work(self):
        threading.Thread(target=self.listen, args=(0,), daemon=True).start()
        self.listen(1)


class Repaired(Robot):
    def serve(self, number):
        with self.lock:
            super().serve(number)
