"""Leads visitors of a theatre to their row. A ticket is `ROW-SEAT-NUMBER`, such as `07-12-88213`."""

import argparse
import logging
import logging.config
import pathlib
import threading

import yaml

from usher.devices import Base, Lamp, TicketScanner

log = logging.getLogger("usher")

IDLE, LEADING, SHOWING, RETURNING, STUCK = "idle", "leading", "showing", "returning", "stuck"


def load_config(path):
    with open(path) as file:
        config = yaml.safe_load(file)
    config.setdefault("patience_s", 30)
    return config


class Usher:
    def __init__(self, config, scanner, base, lamp):
        self.config = config
        self.scanner = scanner
        self.base = base
        self.lamp = lamp
        self.state = IDLE
        self.waiting = []
        self.row = None
        self._timer = None
        self._lock = threading.RLock()
        scanner.on("ticket", self._on_ticket)
        scanner.on("unreadable", lambda: self.lamp.show("red"))
        base.on("arrived", self._on_arrived)
        base.on("blocked", self._on_blocked)

    def open_doors(self):
        for device in (self.scanner, self.base, self.lamp):
            device.switch_on()

    def close_doors(self):
        if self._timer is not None:
            self._timer.cancel()
        for device in (self.scanner, self.base, self.lamp):
            device.switch_off()

    def staff_says(self, word):
        """Staff has a remote control with two buttons."""
        with self._lock:
            if word == "continue" and self.state == STUCK:
                self._enter(RETURNING)
                self.base.drive_to(0)
            elif word == "home" and self.state != RETURNING:
                self.waiting.clear()
                self._enter(RETURNING)
                self.base.drive_to(0)

    def _on_ticket(self, text):
        try:
            row, seat, _ = text.split("-")
            row, seat = int(row), int(seat)
        except ValueError:
            self.lamp.show("red")
            return
        house = self.config["house"]
        if not (0 < row <= house["rows"] and 0 < seat <= house["seats"]):
            self.lamp.show("red")
            return
        with self._lock:
            if self.state == IDLE:
                self._lead(row)
            else:
                self.waiting.append(row)

    def _lead(self, row):
        self.row = row
        self._enter(LEADING)
        self.lamp.show("green")
        self.base.drive_to(row)

    def _on_arrived(self, row):
        with self._lock:
            if self.state == LEADING:
                self._enter(SHOWING)
                self._timer = threading.Timer(self.config["patience_s"], self._go_back)
                self._timer.daemon = True
                self._timer.start()
            elif self.state == RETURNING:
                self._enter(IDLE)
                if self.waiting:
                    self._lead(self.waiting.pop(0))

    def _on_blocked(self, reason):
        with self._lock:
            log.warning("blocked: %s", reason)
            if reason == "bumper":
                self.lamp.show("yellow")
            self._enter(STUCK)

    def _go_back(self):
        with self._lock:
            if self.state == SHOWING:
                self._enter(RETURNING)
                self.base.drive_to(0)

    def _enter(self, state):
        log.info("%s -> %s", self.state, state)
        self.state = state


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--config", default=pathlib.Path(__file__).with_name("config.yaml"))
    parser.add_argument("--port", default="/dev/ttyACM0")
    options = parser.parse_args()
    config = load_config(options.config)
    logging.config.dictConfig({"version": 1, "root": {"level": config["level"]}})

    import serial  # only on the robot
    from theatre_hardware import LedStrip, MotorBoard

    port = serial.Serial(options.port, 9600, timeout=1)
    scanner = TicketScanner("scanner", port)
    usher = Usher(config, scanner, Base("base", MotorBoard()), Lamp("lamp", LedStrip()))
    usher.open_doors()
    try:
        while True:
            line = port.readline().decode("ascii", "replace")
            if line:
                scanner.received(line)
    except KeyboardInterrupt:
        usher.close_doors()


if __name__ == "__main__":
    main()
