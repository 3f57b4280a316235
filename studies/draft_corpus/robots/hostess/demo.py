import time

from hostess.tree import Hostess


class Person:
    def __init__(self, distance):
        self.distance = distance


class Camera:
    def __init__(self):
        self.distances = iter([4.0, 3.0, 2.0, 2.0, 2.0, 2.0])

    def nearest_person(self):
        return Person(next(self.distances, 2.0))


class Voice:
    def __init__(self):
        self.left = 0

    def say(self, text):
        self.left = 2

    def busy(self):
        self.left -= 1
        return self.left > 0


class Ears:
    def __init__(self):
        self.words = iter(["", "", "two"])

    def take(self):
        return next(self.words, "")


class Base:
    def __init__(self):
        self.polls = iter(())

    def drive_to(self, place):
        self.polls = iter(["driving", "blocked", "driving"])

    def status(self):
        return next(self.polls, "there")


hostess = Hostess(Camera(), Voice(), Ears(), Base())
for _ in range(60):
    hostess.tick()
    time.sleep(0.01)
