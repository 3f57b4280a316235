import time

from usher.devices import Base, Lamp, TicketScanner
from usher.usher import Usher


class Port:
    def write(self, data):
        pass


class Motors:
    def __init__(self, *statuses):
        self.statuses = list(statuses)

    def enable(self):
        pass

    disable = halt = enable

    def goto(self, row):
        self.row = row

    def status(self):
        return self.statuses.pop(0) if self.statuses else "driving"


class Strip:
    def set(self, colour):
        pass


def scene(*statuses, patience_s=0.1):
    config = {"house": {"rows": 20, "seats": 24}, "patience_s": patience_s}
    scanner = TicketScanner("scanner", Port())
    usher = Usher(config, scanner, Base("base", Motors(*statuses)), Lamp("lamp", Strip()))
    usher.open_doors()
    return usher, scanner


def wait_for(usher, state):
    end = time.monotonic() + 5
    while usher.state != state and time.monotonic() < end:
        time.sleep(0.02)
    assert usher.state == state


def test_leads_to_the_row_and_returns():
    usher, scanner = scene("driving", "reached", "reached")
    scanner.received("07-12-88213\n")
    wait_for(usher, "showing")
    wait_for(usher, "idle")


def test_bumper():
    usher, scanner = scene("bumper", "reached")
    scanner.received("01-01-00001\n")
    wait_for(usher, "stuck")
    usher.staff_says("continue")
    wait_for(usher, "idle")


def test_wrong_tickets():
    usher, scanner = scene()
    for text in ("abc", "99-01-22222", "no ticket at all"):
        scanner.received(text)
    assert usher.lamp.colour == "red"
    assert usher.state == "idle"
