"""Three arms take the tool at their left and then that at their right: each waits for the next one."""

import threading

from messages import Done, Go


class Robot:
    def __init__(self, ports, bus):
        self.bus = bus
        self.tools = [threading.Lock() for _ in range(3)]
        self.orders = [bus.subscribe(Go) for _ in range(3)]

    def pair(self, number):
        return self.tools[number], self.tools[(number + 1) % 3]

    def arm(self, number):
        while True:
            if self.orders[number].wait(100.0) is not None:
                first, second = self.pair(number)
                with first:  # noqa: SIM117 (between the two is where it waits)
                    with second:
                        self.bus.publish(Done())

    def work(self):
        for number in range(2):
            threading.Thread(target=self.arm, args=(number,), daemon=True).start()
        self.arm(2)


class Repaired(Robot):
    def pair(self, number):
        first, second = sorted((number, (number + 1) % 3))
        return self.tools[first], self.tools[second]
