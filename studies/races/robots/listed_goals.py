"""A planner lists its open goals in one statement while a listener adds one."""

import threading
import time

from messages import Done, Go


class Robot:
    def __init__(self, ports, bus):
        self.bus, self.goes = bus, bus.subscribe(Go)
        self.goals = {}

    def listen(self):
        while self.goes.wait(100.0) is not None:
            self.goals[len(self.goals)] = "wanted"

    def open_goals(self):
        return [number for number, state in self.goals.items() if state == "wanted"]

    def work(self):
        threading.Thread(target=self.listen, daemon=True).start()
        while True:
            for number in self.open_goals():
                self.goals[number] = "done"
                self.bus.publish(Done())
            time.sleep(0.1)


class Repaired(Robot):
    def open_goals(self):
        return [number for number, state in list(self.goals.items()) if state == "wanted"]
