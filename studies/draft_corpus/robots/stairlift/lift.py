"""A stair lift with a seat. The hand controls send lines over a serial port, and the motor answers over another one.

Lines of the hand control: `BTN UP`, `BTN DOWN`, `BTN NONE`, `SEAT 1` (somebody sits), `BELT 1`, `CALL TOP`, `CALL BOTTOM`.
Lines of the motor: `POS <mm>`, `FAULT <number>`.
"""

import argparse
import configparser
import enum
import logging
import queue
import sys
import threading
import time

import serial

logger = logging.getLogger("stairlift")


class State(enum.Enum):
    PARKED = enum.auto()
    READY = enum.auto()
    ASCENDING = enum.auto()
    DESCENDING = enum.auto()
    CALLED = enum.auto()
    BLOCKED = enum.auto()
    FAULT = enum.auto()


class Event(enum.Enum):
    UP = "up"
    DOWN = "down"
    LET_GO = "let go"
    SIT = "sit"
    STAND = "stand"
    BELT = "belt"
    NO_BELT = "no belt"
    CALL_TOP = "call top"
    CALL_BOTTOM = "call bottom"
    TOP = "top"
    BOTTOM = "bottom"
    OBSTACLE = "obstacle"
    FREE = "free"
    BROKEN = "broken"


def to_event(line):
    """The event of a line, or None."""
    match line.split():
        case ["BTN", "UP"]:
            return Event.UP
        case ["BTN", "DOWN"]:
            return Event.DOWN
        case ["BTN", "NONE"]:
            return Event.LET_GO
        case ["SEAT", flag]:
            return Event.SIT if flag == "1" else Event.STAND
        case ["BELT", flag]:
            return Event.BELT if flag == "1" else Event.NO_BELT
        case ["CALL", "TOP"]:
            return Event.CALL_TOP
        case ["CALL", "BOTTOM"]:
            return Event.CALL_BOTTOM
        case ["FAULT", number] if number != "0":
            return Event.BROKEN
        case _:
            return None


class StairLift:
    """The decisions. `step` is called with each event, and whenever nothing has happened for a while."""

    def __init__(self, motor, footrest, length_mm=4200):
        self.motor = motor
        self.footrest = footrest
        self.length_mm = length_mm
        self.state = State.PARKED
        self.seated = False
        self.belted = False
        self.position = 0
        self.goal = None

    def step(self, event):
        before = self.state
        match (self.state, event):
            case (_, Event.BROKEN):
                self.motor.stop()
                self.state = State.FAULT
            case (State.FAULT, _):
                pass
            case (_, Event.SIT):
                self.seated = True
            case (_, Event.STAND):
                self.seated = False
                self.stop(State.PARKED)
            case (State.PARKED, Event.BELT) if self.seated:
                self.belted = True
                self.state = State.READY
            case (_, Event.NO_BELT):
                self.belted = False
                self.stop(State.PARKED)
            case (State.READY, Event.UP) if self.position < self.length_mm:
                self.motor.run(+1)
                self.state = State.ASCENDING
            case (State.READY, Event.DOWN) if self.position > 0:
                self.motor.run(-1)
                self.state = State.DESCENDING
            case (State.ASCENDING | State.DESCENDING, Event.LET_GO):
                self.stop(State.READY)
            case (State.ASCENDING | State.CALLED, Event.TOP):
                self.stop(State.READY if self.belted else State.PARKED)
            case (State.DESCENDING | State.CALLED, Event.BOTTOM):
                self.stop(State.READY if self.belted else State.PARKED)
            case (State.ASCENDING | State.DESCENDING | State.CALLED, Event.OBSTACLE):
                self.stop(State.BLOCKED)
            case (State.BLOCKED, Event.FREE):
                self.state = State.READY if self.belted else State.PARKED
            case (State.PARKED, Event.CALL_TOP | Event.CALL_BOTTOM) if not self.seated:
                self.motor.run(+1 if event is Event.CALL_TOP else -1)
                self.state = State.CALLED
        if self.state is not before:
            logger.info("%s -> %s (%s)", before.name, self.state.name, event.value)

    def stop(self, state):
        if self.state in (State.ASCENDING, State.DESCENDING, State.CALLED):
            self.motor.stop()
        if self.state is not State.FAULT:
            self.state = state

    def poll(self):
        """Look at what has no events of its own."""
        self.position = self.motor.position_mm()
        if self.position >= self.length_mm:
            self.step(Event.TOP)
        elif self.position <= 0:
            self.step(Event.BOTTOM)
        self.step(Event.OBSTACLE if self.footrest.pressed() else Event.FREE)


class Motor:
    """The motor's board. A thread reads what it sends."""

    def __init__(self, port):
        self.port = port
        self._position = 0

    def run(self, direction):
        self.port.write(b"RUN %d\n" % direction)

    def stop(self):
        self.port.write(b"STOP\n")

    def position_mm(self):
        return self._position

    def read(self, events):
        while True:
            line = self.port.readline().decode("ascii", "ignore").strip()
            if line.startswith("POS "):
                self._position = int(line[4:])
            elif (event := to_event(line)) is not None:
                events.put(event)


class Footrest:
    def __init__(self, gpio, pin):
        self.gpio, self.pin = gpio, pin
        gpio.setup(pin, gpio.IN)

    def pressed(self):
        return self.gpio.input(self.pin) == 1


def listen(port, events):
    """The hand controls, in a thread of its own."""
    while True:
        line = port.readline().decode("ascii", "ignore")
        event = to_event(line)
        if event is not None:
            events.put(event)
        elif line.strip():
            logger.warning("unknown: %s", line.strip())


def work(lift, events, poll_s=0.1):
    while True:
        try:
            event = events.get(timeout=poll_s)
        except queue.Empty:
            lift.poll()
        else:
            lift.step(event)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("config", nargs="?", default="stairlift.ini")
    options = parser.parse_args()
    config = configparser.ConfigParser()
    config.read_dict({"ports": {"hand": "/dev/ttyUSB0", "motor": "/dev/ttyUSB1"}, "stairs": {"length_mm": "4200"}})
    config.read(options.config)
    logging.basicConfig(level=logging.INFO, stream=sys.stderr)

    import RPi.GPIO as gpio

    gpio.setmode(gpio.BCM)
    motor = Motor(serial.Serial(config["ports"]["motor"], 115200))
    hand = serial.Serial(config["ports"]["hand"], 9600)
    lift = StairLift(motor, Footrest(gpio, 17), config.getint("stairs", "length_mm"))
    events = queue.Queue()
    threading.Thread(target=motor.read, args=(events,), daemon=True).start()
    threading.Thread(target=listen, args=(hand, events), daemon=True).start()
    time.sleep(0.5)
    work(lift, events)


if __name__ == "__main__":
    main()
