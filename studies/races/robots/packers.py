"""Two packers take two parts for each box when there are two: both may look first, and get one each."""

import queue
import threading
import time

from messages import Done, Go


class Robot:
    def __init__(self, ports, bus):
        self.bus = bus
        self.goes = bus.subscribe(Go)
        self.lock = threading.Lock()
        self.parts = queue.Queue()

    def pack(self):
        if self.parts.qsize() >= 2:
            lower = self.parts.get()
            upper = self.parts.get()
            self.close_box(lower, upper)

    def close_box(self, lower, upper):
        self.bus.publish(Done())

    def run_packer(self):
        while True:
            self.pack()
            time.sleep(0.1)

    def work(self):
        for _ in range(2):
            threading.Thread(target=self.run_packer, daemon=True).start()
        while True:
            if self.goes.wait(100.0) is not None:
                self.parts.put("cup")
                self.parts.put("saucer")


class Repaired(Robot):
    def pack(self):
        with self.lock:
            super().pack()
