"""A button and a remote control start the mixer unless it runs: both may see that it does not."""

import threading
import time

from messages import Go


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.lock = threading.Lock()
        self.worker = None
        self.wishes = [bus.subscribe(Go), bus.subscribe(Go)]

    def mix(self):
        self.ports.begin()
        time.sleep(0.4)
        self.ports.end()
        self.worker = None

    def start(self):
        if self.worker is None:
            self.worker = threading.Thread(target=self.mix, daemon=True)
            self.worker.start()

    def listen(self, wishes):
        while True:
            if wishes.wait(100.0) is not None:
                self.start()

    def work(self):
        threading.Thread(target=self.listen, args=(self.wishes[0],), daemon=True).start()
        self.listen(self.wishes[1])


class Repaired(Robot):
    def start(self):
        with self.lock:
            super().start()
