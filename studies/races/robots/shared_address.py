"""Two senders write the address on one and the same envelope before each sends its letter."""

import threading

from messages import Go


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.lock = threading.Lock()
        self.doors = [bus.subscribe(Go), bus.subscribe(Go)]
        self.envelope = {"to": None}
        self.wrong = 0

    def listen(self, number):
        while True:
            if self.doors[number].wait(100.0) is not None:
                self.serve(number)

    def serve(self, number):
        self.envelope["to"] = number
        letter = dict(self.envelope)
        self.wrong += letter["to"] != number
        self.ports.set("lost", self.wrong)

    def work(self):
        threading.Thread(target=self.listen, args=(0,), daemon=True).start()
        self.listen(1)


class Repaired(Robot):
    def serve(self, number):
        with self.lock:
            super().serve(number)
