"""Small robots, as people write them: source text by name."""

from __future__ import annotations

TRANSITIONS = """
import asyncio
from dataclasses import dataclass
from transitions.extensions.asyncio import AsyncMachine


@dataclass(frozen=True)
class Button:
    name: str  # which one


@dataclass(frozen=True)
class Status:
    state: str


TRANSITIONS = [
    {"trigger": "call", "source": "idle", "dest": "moving"},
    ["arrive", "moving", "open"],
    ["close", "open", "idle"],
    {"trigger": "stop", "source": ["moving", "open"], "dest": "halted"},
    {"trigger": "reset", "source": "*", "dest": "idle"},
]


class Lift:
    STATES = ["idle", "moving", "open", "halted"]

    def __init__(self, inbox: asyncio.Queue[Button], outbox: asyncio.Queue[Status]):
        self.inbox, self.outbox = inbox, outbox
        self.machine = AsyncMachine(self, states=Lift.STATES, transitions=TRANSITIONS, initial="idle")

    async def run(self):
        while True:
            button = await self.inbox.get()
            if button.name == "call" and self.state == "idle":
                await self.call()
                await self.tell()
                await asyncio.sleep(2.0)
                await self.arrive()
                await self.tell()
                await asyncio.sleep(1.0)
                await self.close()
            elif button.name == "stop":
                await self.reset()
            await self.tell()

    async def tell(self):
        await self.outbox.put(Status(self.state))
"""

STATEMACHINE = """
from statemachine import State, StateMachine


class Door(StateMachine):
    closed = State(initial=True)
    opening = State()
    opened = State()
    broken = State(final=True)

    open = closed.to(opening)
    done = opening.to(opened)
    close = opened.to(closed) | opening.to(closed)
    fail = broken.from_(opening, opened)
"""

MATCH = '''
import time
from dataclasses import dataclass
from enum import Enum
from typing import Literal


class Mode(Enum):
    IDLE = "idle"
    FETCHING = "fetching"
    OFFERING = "offering"
    FAULT = "fault"


@dataclass(frozen=True)
class Command:
    kind: Literal["fetch", "abort"]


@dataclass(frozen=True)
class Taken:
    """The person has taken it."""


@dataclass(frozen=True)
class ModeChanged:
    mode: Mode


OFFER_S = 5.0


class Fetcher:
    def __init__(self, bus, gripper):
        self.bus, self.gripper = bus, gripper
        self.mode = Mode.IDLE
        self.commands, self.taken = bus.subscribe(Command), bus.subscribe(Taken)

    def enter(self, mode: Mode) -> None:
        self.mode = mode
        self.bus.publish(ModeChanged(mode))

    def run(self) -> None:
        while True:
            match self.mode:
                case Mode.IDLE:
                    self.wait_for_command()
                case Mode.FETCHING:
                    self.fetch()
                case Mode.OFFERING:
                    self.enter(Mode.IDLE if self.taken.wait(OFFER_S) else Mode.FAULT)
                case Mode.FAULT:
                    time.sleep(1.0)
                    self.gripper.open()
                    self.enter(Mode.IDLE)

    def wait_for_command(self) -> None:
        command = self.commands.wait(1.0)
        if command is not None and command.kind == "fetch":
            self.enter(Mode.FETCHING)

    def fetch(self) -> None:
        time.sleep(2.0)
        if not self.gripper.close():
            self.enter(Mode.FAULT)
            return
        self.enter(Mode.OFFERING)
'''
