"""Two hands raise a flag before they reach for a part, and leave it to each other where both see the other's flag."""

import queue
import threading

from messages import Done, Go


class Robot:
    def __init__(self, ports, bus):
        self.bus, self.goes = bus, bus.subscribe(Go)
        self.calls = [queue.Queue(), queue.Queue()]
        self.reaches = [False, False]
        self.lock = threading.Lock()
        self.parts = []

    def take(self):
        if self.parts:
            self.parts.pop()
            self.bus.publish(Done())

    def reach(self, hand):
        self.reaches[hand] = True
        if not self.reaches[1 - hand]:
            self.take()
        self.reaches[hand] = False

    def serve(self, hand):
        while True:
            self.calls[hand].get()
            self.reach(hand)

    def work(self):
        for hand in range(2):
            threading.Thread(target=self.serve, args=(hand,), daemon=True).start()
        while self.goes.wait(100.0) is not None:
            self.parts.append("part")
            for calls in self.calls:
                calls.put("part")


class Repaired(Robot):
    def reach(self, hand):
        with self.lock:
            self.take()
