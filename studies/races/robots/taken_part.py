"""An arm that was told of a part finds none, as a helper came by first; it does not look again."""

import threading

from messages import Done, Go


class Robot:
    def __init__(self, ports, bus):
        self.bus = bus
        self.helps, self.feeds = bus.subscribe(Go), bus.subscribe(Go)
        self.parts, self.changed = [], threading.Condition()

    def take(self):
        with self.changed:
            if not self.parts:
                self.changed.wait()
            return self.parts.pop()

    def move(self):
        while True:
            self.take()
            self.bus.publish(Done())

    def help(self):
        while self.helps.wait(100.0) is not None:
            with self.changed:
                found = self.parts and self.parts.pop()
            if found:
                self.bus.publish(Done())

    def work(self):
        for target in (self.move, self.help):
            threading.Thread(target=target, daemon=True).start()
        while self.feeds.wait(100.0) is not None:
            with self.changed:
                self.parts.append("part")
                self.changed.notify()


class Repaired(Robot):
    def take(self):
        with self.changed:
            while not self.parts:
                self.changed.wait()
            return self.parts.pop()
