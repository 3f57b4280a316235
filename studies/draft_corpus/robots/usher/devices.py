"""The devices of the usher: each one has a name, and tells whoever is interested what happens to it."""

import abc
import logging
import threading
import time

log = logging.getLogger(__name__)


class Device(abc.ABC):
    """Something that is switched on and off, and that can be listened to."""

    events = ()

    def __init__(self, name):
        self.name = name
        self.callbacks = {event: [] for event in self.events}
        self.is_on = False

    def on(self, event, callback):
        if event not in self.callbacks:
            raise KeyError(f"{self.name} has no event {event!r}")
        self.callbacks[event].append(callback)

    def emit(self, event, *args):
        log.debug("%s: %s %s", self.name, event, args)
        for callback in self.callbacks[event]:
            callback(*args)

    @abc.abstractmethod
    def switch_on(self):
        ...

    @abc.abstractmethod
    def switch_off(self):
        ...


class TicketScanner(Device):
    """A bar code scanner: emits the text of each ticket."""

    events = ("ticket", "unreadable")

    def __init__(self, name, port):
        super().__init__(name)
        self.port = port

    def switch_on(self):
        self.is_on = True
        self.port.write(b"SCAN ON\n")

    def switch_off(self):
        self.is_on = False
        self.port.write(b"SCAN OFF\n")

    def received(self, line):
        """Called by whoever reads the port."""
        if not self.is_on:
            return
        text = line.strip()
        if len(text) < 6:
            self.emit("unreadable")
        else:
            self.emit("ticket", text)


class Base(Device):
    """The wheels. Driving takes time, so that it is done in a thread."""

    events = ("arrived", "blocked")

    def __init__(self, name, motors):
        super().__init__(name)
        self.motors = motors
        self._stop = threading.Event()

    def switch_on(self):
        self.is_on = True
        self.motors.enable()

    def switch_off(self):
        self.is_on = False
        self._stop.set()
        self.motors.disable()

    def drive_to(self, row):
        self._stop.clear()
        threading.Thread(target=self._drive, args=(row,), daemon=True).start()

    def _drive(self, row):
        self.motors.goto(row)
        deadline = time.monotonic() + 60.0
        while time.monotonic() < deadline:
            if self._stop.wait(0.2):
                self.motors.halt()
                return
            status = self.motors.status()
            if status == "bumper":
                self.motors.halt()
                self.emit("blocked", "bumper")
                return
            if status == "reached":
                self.emit("arrived", row)
                return
        self.emit("blocked", "timeout")


class Lamp(Device):
    """A lamp of three colours. Nothing ever happens to it."""

    def __init__(self, name, strip):
        super().__init__(name)
        self.strip = strip
        self.colour = "off"

    def switch_on(self):
        self.is_on = True
        self.show("white")

    def switch_off(self):
        self.show("off")
        self.is_on = False

    def show(self, colour):
        self.colour = colour
        self.strip.set(colour)
