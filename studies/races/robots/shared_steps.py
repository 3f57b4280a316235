"""Two wheels take their steps from one generator, which does not bear two callers at once."""

import threading

from messages import Done, Go


class Robot:
    def __init__(self, ports, bus):
        self.bus = bus
        self.wheels = [bus.subscribe(Go), bus.subscribe(Go)]
        self.steps = self.plan()

    def plan(self):
        angle = 0
        while True:
            angle = (angle + 30) % 360
            yield angle

    def step(self):
        return next(self.steps)

    def turn(self, goes):
        while goes.wait(100.0) is not None:
            self.step()
            self.bus.publish(Done())

    def work(self):
        threads = [threading.Thread(target=self.turn, args=(goes,), daemon=True) for goes in self.wheels]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()


class Repaired(Robot):
    lock = threading.Lock()

    def step(self):
        with self.lock:
            return super().step()
