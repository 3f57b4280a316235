"""Two callers look whether a grip is running in the pool, and both submit one."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor

from messages import Go


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.callers = [bus.subscribe(Go), bus.subscribe(Go)]
        self.pool, self.grip_done = ThreadPoolExecutor(2), None

    def grip(self):
        self.ports.begin()
        time.sleep(0.2)
        self.ports.end()

    def ask(self):
        if self.grip_done is None or self.grip_done.done():
            self.grip_done = self.pool.submit(self.grip)

    def call(self, goes):
        while goes.wait(100.0) is not None:
            self.ask()

    def work(self):
        threads = [threading.Thread(target=self.call, args=(goes,), daemon=True) for goes in self.callers]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()


class Repaired(Robot):
    lock = threading.Lock()

    def ask(self):
        with self.lock:
            super().ask()
