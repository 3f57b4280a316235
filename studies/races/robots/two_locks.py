"""Moving takes the arm and then the hand, letting go takes the hand and then the arm: each may wait for the other."""

import threading

from messages import Done, Go


class Robot:
    def __init__(self, ports, bus):
        self.bus = bus
        self.ports = ports
        self.moves, self.opens = bus.subscribe(Go), bus.subscribe(Go)
        self.arm, self.hand = threading.Lock(), threading.Lock()
        self.is_open = False

    def move(self):
        with self.arm:
            self.ports.move(True)
            with self.hand:
                self.ports.move(self.is_open)

    def open(self):
        with self.hand:
            self.is_open = not self.is_open
            with self.arm:
                self.bus.publish(Done())

    def obey(self, orders, action):
        while True:
            if orders.wait(100.0) is not None:
                action()

    def work(self):
        threading.Thread(target=self.obey, args=(self.opens, self.open), daemon=True).start()
        self.obey(self.moves, self.move)


class Repaired(Robot):
    def open(self):
        with self.arm, self.hand:
            self.is_open = not self.is_open
            self.bus.publish(Done())
