"""A watchdog tells the motion loop to halt before it wipes the loop's last answer: it may wipe the new one."""

import threading
import time

from messages import Go, Stop


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.goes, self.stops = bus.subscribe(Go), bus.subscribe(Stop)
        self.halt, self.at_rest, self.lifted = threading.Event(), threading.Event(), threading.Event()
        self.is_wanted = False

    def ask(self):
        self.halt.set()
        self.at_rest.clear()

    def watch(self):
        while self.stops.wait(100.0) is not None:
            self.lifted.clear()
            self.ask()
            self.at_rest.wait()
            self.halt.clear()
            self.lifted.set()

    def listen(self):
        while self.goes.wait(100.0) is not None:
            self.is_wanted = True

    def step(self):
        if self.halt.is_set():
            self.ports.move(False)
            self.is_wanted = False
            self.at_rest.set()
            self.lifted.wait()
        elif self.is_wanted:
            self.ports.move(True)

    def work(self):
        for target in (self.watch, self.listen):
            threading.Thread(target=target, daemon=True).start()
        while True:
            self.step()
            time.sleep(0.05)


class Repaired(Robot):
    def ask(self):
        self.at_rest.clear()
        self.halt.set()
