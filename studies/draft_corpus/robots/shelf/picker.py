"""Fetches books from a high shelf. A control loop calls `update` at 10 Hz with what has come in."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field
from typing import NamedTuple


class Fetch(NamedTuple):
    book: str
    level: int


class Put(NamedTuple):
    level: int


class Halt(NamedTuple):
    by: str


Command = Fetch | Put | Halt


@dataclass
class Inputs:
    commands: list[Command] = field(default_factory=list)
    hand_seen: bool = False
    gripped: bool = False
    height_m: float = 0.0


@dataclass
class Outputs:
    lift_speed: float = 0.0
    gripper_closed: bool = False
    lamp: str = "off"


LEVELS = [0.4, 0.8, 1.2, 1.6]


class Idle:
    def step(self, picker: Picker, inputs: Inputs, outputs: Outputs) -> object:
        if picker.pending:
            command = picker.pending.popleft()
            if 0 <= command.level < len(LEVELS):
                return Lifting(command)
        outputs.lamp = "off"
        return self


class Lifting:
    def __init__(self, command: Fetch | Put) -> None:
        self.command = command

    def step(self, picker: Picker, inputs: Inputs, outputs: Outputs) -> object:
        gap = LEVELS[self.command.level] - inputs.height_m
        outputs.lamp = "yellow"
        if abs(gap) < 0.02:
            return Gripping() if isinstance(self.command, Fetch) else Handing()
        outputs.lift_speed = 0.2 if gap > 0 else -0.2
        return self


class Gripping:
    def step(self, picker: Picker, inputs: Inputs, outputs: Outputs) -> object:
        outputs.gripper_closed = picker.closed = True
        return Handing() if inputs.gripped else self


class Handing:
    def __init__(self) -> None:
        self.ticks = 0

    def step(self, picker: Picker, inputs: Inputs, outputs: Outputs) -> object:
        self.ticks += 1
        outputs.lamp = "green"
        if inputs.hand_seen:
            picker.closed = False
            return Idle()
        return Idle() if self.ticks > 300 else self


class Stopped:
    def step(self, picker: Picker, inputs: Inputs, outputs: Outputs) -> object:
        outputs.lamp = "red"
        return Idle() if inputs.hand_seen else self


class Picker:
    def __init__(self) -> None:
        self.state: object = Idle()
        self.pending: deque[Fetch | Put] = deque()
        self.closed = False

    def update(self, inputs: Inputs) -> Outputs:
        outputs = Outputs(gripper_closed=self.closed)
        for command in inputs.commands:
            match command:
                case Halt():
                    self.pending.clear()
                    self.state = Stopped()
                case Fetch() | Put():
                    self.pending.append(command)
        self.state = self.state.step(self, inputs, outputs)
        return outputs
