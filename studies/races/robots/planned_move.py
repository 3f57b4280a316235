"""A plan made in a pool starts the move if it is still the one that is wanted, although a stop comes just then."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor

from messages import Go, Stop


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.goes, self.stops = bus.subscribe(Go), bus.subscribe(Stop)
        self.pool = ThreadPoolExecutor(max_workers=4)
        self.lock = threading.RLock()
        self.wanted = None

    def plan(self):
        time.sleep(1.0)
        return "path"

    def planned(self, future):
        if future is self.wanted:
            self.ports.move(True)

    def on_go(self):
        self.wanted = self.pool.submit(self.plan)
        self.wanted.add_done_callback(self.planned)

    def on_stop(self):
        future, self.wanted = self.wanted, None
        if future is not None:
            future.cancel()
        self.ports.move(False)

    def watch(self):
        while True:
            if self.stops.wait(100.0) is not None:
                self.on_stop()

    def work(self):
        threading.Thread(target=self.watch, daemon=True).start()
        while True:
            if self.goes.wait(100.0) is not None:
                self.on_go()


class Repaired(Robot):
    def planned(self, future):
        with self.lock:
            super().planned(future)

    def on_go(self):
        with self.lock:
            super().on_go()

    def on_stop(self):
        with self.lock:
            super().on_stop()
