"""Small robots with a function for each class of messages: source text by name."""

from __future__ import annotations

_MESSAGES = """
import queue
from dataclasses import dataclass
from enum import Enum, auto


class Mode(Enum):
    IDLE = auto()
    BUSY = auto()
    STOPPED = auto()


@dataclass(frozen=True)
class Limits:
    near_m: float = 0.5
    far_m: float = 1.5


@dataclass
class Fetch:
    title: str
    level: int


@dataclass
class Cancel:
    reason: str = ""


@dataclass
class Range:
    metres: float


@dataclass
class Reset:
    code: int


@dataclass
class Changed:
    mode: Mode
"""

TABLE = (
    _MESSAGES
    + """

class Robot:
    def __init__(self, inbox: queue.Queue, emit, limits: Limits = Limits()):
        self.inbox = inbox
        self.emit = emit
        self.limits = limits
        self.mode = Mode.IDLE
        self.handlers = {Fetch: self.on_fetch, Cancel: self.on_cancel, Range: self.on_distance, Reset: self.on_reset}

    def run(self):
        while True:
            message = self.inbox.get()
            handler = self.handlers.get(type(message))
            if handler is not None:
                handler(message)

    def on_fetch(self, order):
        if self.mode is Mode.IDLE and 0 <= order.level <= 4:
            self.enter(Mode.BUSY)

    def on_cancel(self, cancel):
        if self.mode is Mode.BUSY and cancel.reason in ("wrong book", "too late"):
            self.enter(Mode.IDLE)

    def on_distance(self, message):
        if message.metres < self.limits.near_m and self.mode is Mode.BUSY:
            self.enter(Mode.STOPPED)

    def on_reset(self, reset):
        if self.mode is Mode.STOPPED and reset.code in (7, 9):
            self.enter(Mode.IDLE)

    def enter(self, mode):
        self.mode = mode
        self.emit(Changed(mode))
"""
)
"""A table from a class to a method, looked up by `type(message)`; limits in a class with defaults."""

DISPATCH = (
    _MESSAGES
    + """
from functools import singledispatchmethod


class Robot:
    def __init__(self, inbox: queue.Queue, emit):
        self.inbox = inbox
        self.emit = emit
        self.mode = Mode.IDLE

    def run(self):
        while True:
            self.handle(self.inbox.get())

    @singledispatchmethod
    def handle(self, message):
        raise TypeError(f"no message: {message!r}")

    @handle.register
    def _(self, order: Fetch):
        if self.mode is Mode.IDLE:
            self.enter(Mode.BUSY)

    @handle.register(Cancel)
    def _(self, cancel):
        if self.mode is Mode.BUSY and cancel.reason == "wrong book":
            self.enter(Mode.IDLE)

    def enter(self, mode):
        self.mode = mode
        self.emit(Changed(mode))
"""
)
"""Single dispatch, by annotation and by argument."""

GAUGE = """
import struct

import serial


def run():
    line = serial.Serial("/dev/ttyUSB0", 9600, timeout=0.5)
    while True:
        line.write(b"F")
        (force,) = struct.unpack("<f", line.read(4))
        if force > 20.0:
            line.write(b"S")
"""
"""A serial line of packed numbers."""
