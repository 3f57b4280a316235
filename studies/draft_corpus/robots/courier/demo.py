"""Run a courier on a pretended base for a few seconds."""

import time

from courier.robot import Courier


class Base:
    def __init__(self):
        self.left = 0
        self.charge = 60
        self.load = True

    def go_to(self, x, y):
        self.left = 3

    def arrived(self):
        self.left -= 1
        return self.left <= 0

    def has_load(self):
        self.load = not self.load
        return self.load

    def battery(self):
        self.charge -= 30
        if self.charge < 0:
            self.charge = 90
        return self.charge

    def dock(self):
        pass


class Speaker:
    def say(self, text):
        print(text)


def main():
    courier = Courier(Base(), Speaker())
    courier.start()
    courier.jobs.put({"kind": "deliver", "to": "anna", "weight": 1.5})
    courier.jobs.put({"kind": "deliver", "to": "lab", "weight": 7.0})
    courier.jobs.put({"kind": "pause"})
    courier.jobs.put({"kind": "deliver", "to": "ben"})
    courier.jobs.put({"kind": "resume"})
    courier.jobs.put({"kind": "home"})
    time.sleep(5)
    courier.stop()


if __name__ == "__main__":
    main()
