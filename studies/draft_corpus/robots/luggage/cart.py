"""A cart that carries luggage between the lobby and the rooms of a hotel."""

from __future__ import annotations

import enum
import logging
import threading
import time

from luggage.commands import Bring, Fetch, Hold, Release, Resume

logger = logging.getLogger(__name__)


class Mode(enum.Enum):
    LOBBY = "lobby"
    RIDING = "riding"
    LIFT = "lift"
    AT_ROOM = "at room"
    UNLOCKED = "unlocked"
    HELD = "held"


class Cart:
    def __init__(self, wheels, lift, lock, pin: str = "2468", floors: int = 6, wait_s: float = 120.0) -> None:
        self.wheels = wheels
        self.lift = lift
        self.lock = lock
        self.pin = pin
        self.floors = floors
        self.wait_s = wait_s
        self.mode = Mode.LOBBY
        self.before = Mode.LOBBY
        self.room = 0
        self.floor = 0
        self.errors = 0
        self.listeners = []
        self._arrived_at = 0.0
        self._running = threading.Event()

    # --- commands

    def handle(self, command) -> str:
        name = type(command).__name__.lower()
        return getattr(self, "do_" + name)(command)

    def do_fetch(self, command: Fetch) -> str:
        if self.mode is not Mode.LOBBY:
            return "busy"
        if not 1 <= command.bags <= 4:
            return "too many bags"
        return self._ride_to(command.room)

    def do_bring(self, command: Bring) -> str:
        if self.mode is not Mode.LOBBY:
            return "busy"
        if command.knock not in ("door", "phone", "none"):
            return "cannot knock like this"
        self.knock = command.knock
        return self._ride_to(command.room)

    def do_release(self, command: Release) -> str:
        if self.mode is not Mode.AT_ROOM:
            return "not at a room"
        if command.pin != self.pin:
            self.errors += 1
            if self.errors >= 3:
                self._enter(Mode.HELD)
            return "wrong pin"
        self.errors = 0
        self.lock.open()
        self._enter(Mode.UNLOCKED)
        return "ok"

    def do_hold(self, command: Hold) -> str:
        if self.mode is Mode.HELD:
            return "held already"
        self.before = self.mode
        self.wheels.stop()
        self._enter(Mode.HELD)
        return "ok"

    def do_resume(self, command: Resume) -> str:
        if self.mode is not Mode.HELD:
            return "not held"
        self.errors = 0
        self._enter(self.before)
        return "ok"

    # --- work

    def start(self) -> None:
        self._running.set()
        threading.Thread(target=self._work, name="cart", daemon=True).start()

    def stop(self) -> None:
        self._running.clear()

    def _work(self) -> None:
        while self._running.is_set():
            self.step()
            time.sleep(0.1)

    def step(self) -> None:
        if self.mode is Mode.RIDING:
            if self.wheels.obstacle_cm() < 30:
                self.wheels.stop()
                return
            if self.floor != self.room // 100:
                self._enter(Mode.LIFT)
                self.lift.call(self.room // 100)
                return
            self.wheels.go(self.room)
            if self.wheels.place() == self.room:
                self._arrived_at = time.monotonic()
                self._enter(Mode.LOBBY if self.room == 0 else Mode.AT_ROOM)
        elif self.mode is Mode.LIFT:
            answer = self.lift.state()
            if answer == "open":
                self.floor = self.room // 100
                self._enter(Mode.RIDING)
            elif answer == "broken":
                self._enter(Mode.HELD)
        elif self.mode is Mode.UNLOCKED:
            if self.lock.is_closed():
                self._ride_to(0)
        elif self.mode is Mode.AT_ROOM:
            if time.monotonic() - self._arrived_at > self.wait_s:
                self._ride_to(0)

    def _ride_to(self, room: int) -> str:
        if not 0 <= room // 100 <= self.floors:
            return "no such room"
        self.room = room
        self._enter(Mode.RIDING)
        return "ok"

    def _enter(self, mode: Mode) -> None:
        logger.info("%s -> %s", self.mode.value, mode.value)
        self.mode = mode
        for listener in self.listeners:
            listener(mode.value)
