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

SMACH = """
import smach


class Find(smach.State):
    def __init__(self):
        smach.State.__init__(self, outcomes=["found", "lost"])

    def execute(self, userdata):
        return "found"


def main():
    sm = smach.StateMachine(outcomes=["done", "failed"])
    with sm:
        smach.StateMachine.add("FIND", Find(), transitions={"found": "GRASP", "lost": "failed"})
        smach.StateMachine.add("GRASP", Find(), transitions={"found": "HAND_OVER", "lost": "FIND"})
        smach.StateMachine.add("HAND_OVER", Find(), transitions={"found": "done", "lost": "FIND"})
    sm.execute()
"""

YASMIN = """
from yasmin import CbState, StateMachine
from yasmin_ros.basic_outcomes import SUCCEED

IDLE, WORK = "IDLE", "WORK"


def main():
    sm = StateMachine(outcomes=["outcome4"])
    sm.add_state(IDLE, CbState([SUCCEED], idle), transitions={SUCCEED: WORK})
    sm.add_state(WORK, CbState(["again", "end"], work), transitions={"again": IDLE, "end": "outcome4"})
    sm()


def idle(blackboard):
    return SUCCEED


def work(blackboard):
    return "end"
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

CHAIN = """
import queue
import time

IDLE, DRIVE, TURN = "idle", "drive", "turn"


class Rover:
    def __init__(self, commands: queue.Queue, reports: queue.Queue, motors):
        self.commands, self.reports, self.motors = commands, reports, motors
        self.state = IDLE

    def run(self):
        while True:
            try:
                command = self.commands.get(timeout=0.5)
            except queue.Empty:
                command = None
            if self.state == IDLE:
                if command == "go":
                    self.state = DRIVE
            elif self.state == DRIVE:
                self.motors.drive(0.2)
                if self.motors.bumped():
                    self.state = TURN
                elif command == "halt":
                    self.state = IDLE
            elif self.state == TURN:
                self.motors.turn(1.57)
                time.sleep(1.57)
                self.state = DRIVE
            self.reports.put({"state": self.state, "speed_m_s": 0.2})
"""

DISPATCH = """
import time


class Waiter:
    def __init__(self, publish, arm):
        self._publish, self._arm = publish, arm
        self._state = "home"
        self._handlers = {"home": self._home, "serving": self._serving, "clearing": self._clearing}

    def on_order(self, table: int) -> None:
        self._ordered = table

    def run(self):
        self._ordered = None
        while True:
            self._state = self._handlers[self._state]()
            self._publish("waiter/state", self._state)

    def _home(self):
        time.sleep(0.5)
        return "serving" if self._ordered is not None else "home"

    def _serving(self):
        return "clearing" if self._arm.is_free() else "home"

    def _clearing(self):
        self._ordered = None
        return "home"
"""

TABLE = """
from enum import Enum, auto


class Step(Enum):
    WAIT = auto()
    PICK = auto()
    PLACE = auto()


NEXT = {
    (Step.WAIT, "asked"): Step.PICK,
    (Step.PICK, "held"): Step.PLACE,
    (Step.PICK, "lost"): Step.WAIT,
    (Step.PLACE, "done"): Step.WAIT,
}


def run(bus, events):
    step = Step.WAIT
    while True:
        step = NEXT.get((step, events.next_event()), step)
"""

GUARDS = """
from enum import Enum


class S(str, Enum):
    OFF = "off"
    ON = "on"
    LOCKED = "locked"


class Lamp:
    def __init__(self, port):
        self.port, self.state = port, S.OFF

    def on_press(self, _):
        if self.state is S.LOCKED:
            return
        self.state = S.ON if self.state == S.OFF else S.OFF

    def on_lock(self, _):
        if self.state not in (S.OFF, S.ON):
            return
        self.state = S.LOCKED

    def on_unlock(self, _):
        if self.state != S.LOCKED:
            self.port.beep()
            return
        self.state = S.OFF
"""

TREE = """
import py_trees


class Reach(py_trees.behaviour.Behaviour):
    def __init__(self, name="Reach"):
        super().__init__(name)

    def update(self):
        return py_trees.common.Status.SUCCESS


class Grasp(py_trees.behaviour.Behaviour):
    def update(self):
        return py_trees.common.Status.RUNNING


def tree():
    root = py_trees.composites.Sequence(name="Handover", memory=True)
    root.add_children([Reach(), Grasp(name="Grasp cup"), py_trees.behaviours.Success(name="Say done")])
    return root
"""

CLASSES = """
from __future__ import annotations

import queue
import time
from abc import ABC, abstractmethod
from dataclasses import dataclass


@dataclass
class Order:
    ward: str


@dataclass
class Handed:
    by: str


@dataclass
class Alarm:
    reason: str


class State(ABC):
    @abstractmethod
    def run(self, cart: Cart) -> State: ...


class Idle(State):
    def run(self, cart):
        event = cart.next_event()
        if isinstance(event, Order):
            cart.job = event
            return Driving()
        return self


class Driving(State):
    def run(self, cart):
        time.sleep(20.0 if cart.job.ward == "north" else 5.0)
        return HandOver()


class HandOver(State):
    def run(self, cart):
        event = cart.next_event()
        if not isinstance(event, Handed):
            cart.emit(Alarm("nobody took it"))
        return Idle()


class Cart:
    def __init__(self, inbox: queue.Queue, outbox: queue.Queue):
        self.inbox = inbox
        self.outbox = outbox
        self.state = Idle()
        self.job = None

    def next_event(self):
        try:
            return self.inbox.get(timeout=30.0)
        except queue.Empty:
            return None

    def emit(self, event):
        self.outbox.put(event)

    def run(self):
        while True:
            self.state = self.state.run(self)
"""

CONTEXT = """
class Closed:
    def __init__(self, door):
        self.door = door

    def pressed(self):
        self.door.change(Opening(self.door))


class Opening:
    def __init__(self, door):
        self.door = door

    def pressed(self):
        self.door.change(Closed(self.door))


class Door:
    def __init__(self):
        self._state = Closed(self)

    def change(self, state):
        self._state = state

    def press(self):
        self._state.pressed()
"""
"""States without a base class, which have the robot and change its state."""
