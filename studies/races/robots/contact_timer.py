"""Two contact strips start a timer anew that ends the move: one may lose the timer of the other, which goes on."""

import threading

from messages import Go


class Robot:
    def __init__(self, ports, bus):
        self.ports = ports
        self.strips = [bus.subscribe(Go), bus.subscribe(Go)]
        self.lock = threading.Lock()
        self.timer = None

    def rest(self):
        self.ports.move(False)

    def restart(self):
        if self.timer is not None:
            self.timer.cancel()
        timer = threading.Timer(1.6, self.rest)
        timer.start()
        self.timer = timer

    def touch(self):
        self.ports.move(True)
        self.restart()

    def feel(self, strip):
        while True:
            if strip.wait(100.0) is not None:
                self.touch()

    def work(self):
        threading.Thread(target=self.feel, args=(self.strips[0],), daemon=True).start()
        self.feel(self.strips[1])


class Repaired(Robot):
    def rest(self):
        with self.lock:
            if threading.current_thread() is self.timer:
                super().rest()

    def touch(self):
        with self.lock:
            super().touch()
