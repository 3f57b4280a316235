"""Which readings of a device follow what it is told: a base that drives, a gripper that closes, a lift that goes up.

Concluded from names alone, so a draft marks each as a question.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import zip_longest
from typing import Literal

from pytest_hricdv.extra.draft.found.port import Operation, Part, Port
from pytest_hricdv.extra.draft.surroundings.motion_words import (
    DEEDS,
    DRIVES,
    GOES,
    HALTS,
    POSES,
    STORES,
    axis,
    bare,
    speed,
    way,
    words,
)

Kind = Literal["drive", "wheels", "reach", "speed", "target", "switch", "up", "down"]


@dataclass(frozen=True)
class Value:
    """A value that a port says or is told: a reading or an argument, or a part of one.

    Args:
        operation: the method or attribute.
        index: of the argument; 0 of what it returns.
        part: the number of the part; None where it has none.
        name: of the part, the argument or the operation.
        kind: "bool", "float", "floats", "str", or empty.
        compared: numbers that the code compares it with.
    """

    operation: Operation
    index: int
    part: int | None
    name: str
    kind: str
    compared: tuple[float, ...] = ()


@dataclass(frozen=True)
class Command:
    """What a device is told that something follows: by values, or by the mere call."""

    kind: Kind
    values: tuple[Value, ...]
    operation: Operation


@dataclass(frozen=True)
class Motion:
    """Something of a device that moves.

    Args:
        readings: what says where it is: of a pose x, y and the heading, if there is one; else one value.
        commands: what it follows.
    """

    readings: tuple[Value, ...]
    commands: tuple[Command, ...]

    @property
    def is_pose(self) -> bool:
        """Whether it is a pose in the plane."""
        return len(self.readings) > 1


def motions(port: Port) -> tuple[Motion, ...]:
    """What moves of a device."""
    pose = _pose(port)
    drives = tuple(_drives(port)) if pose else ()
    found = [Motion(pose, drives)] if drives else []
    taken = {id(command.operation) for command in drives}
    read = [value for value in readings(port) if value not in pose and value.kind in ("bool", "float")]
    for reading in read:
        is_alone = reading.kind == "float" and sum(other.kind == "float" for other in read) == 1
        commands = tuple(
            command
            for operation in port.operations
            if id(operation) not in taken and operation is not reading.operation
            for command in _follows(reading, operation, is_alone)
        )
        found += [Motion((reading,), commands)] if commands else []
    return tuple(found)


def readings(port: Port) -> Iterator[Value]:
    """All that the code reads at a port."""
    for operation in port.operations:
        if operation.is_set:
            continue
        if operation.parts:
            for number, part in enumerate(operation.parts):
                yield Value(operation, 0, number, part.name, part.kind, part.compared)
        else:
            kind = {"bool": "bool", "float": "float", "int": "float"}.get(operation.returns, "")
            yield Value(operation, 0, None, operation.name, kind, operation.compared)


def told_values(operation: Operation) -> Iterator[Value]:
    """All that an operation tells a port."""
    names = ("",) if operation.kind == "attribute" else operation.arguments
    if operation.kind == "attribute" and not operation.is_set:
        return
    parts_of: tuple[tuple[Part, ...], ...] = operation.told_parts[: len(names)]
    for index, (name, kind, parts) in enumerate(zip_longest(names, operation.told[: len(names)], parts_of)):
        if parts:
            for number, part in enumerate(parts):
                yield Value(operation, index, number, part.name, part.kind)
        else:
            yield Value(operation, index, None, name or operation.name, kind or "")


def _pose(port: Port) -> tuple[Value, ...]:
    """The values that say where a device is in the plane; none where there is no pose."""
    for operation in port.operations:
        parts = [value for value in readings(port) if value.operation is operation and value.part is not None]
        found = _axes(parts)
        if not found and len(parts) in (2, 3) and bare(operation.name) in POSES and operation.made[:1] in ("", "("):
            found = tuple(parts)  # of a tuple, in the usual order
        if found:
            return found
    return _axes([value for value in readings(port) if value.part is None])


def _axes(values: list[Value]) -> tuple[Value, ...]:
    """x, y and the heading among values; none where x or y is not."""
    by_axis = {axis(value.name): value for value in reversed(values) if axis(value.name)}
    if not {"x", "y"} <= set(by_axis):
        return ()
    return tuple(by_axis[name] for name in ("x", "y", "heading") if name in by_axis)


def _drives(port: Port) -> Iterator[Command]:
    """The operations by which a device is told how fast to drive."""
    for operation in port.operations:
        values = [value for value in told_values(operation) if value.kind != "str"]
        by_part = {speed(value.name): value for value in reversed(values) if speed(value.name)}
        if places := _axes(values):
            yield Command("reach", places[:2], operation)
        elif {"left", "right"} <= set(by_part):
            yield Command("wheels", (by_part["left"], by_part["right"]), operation)
        elif {"forward", "turn"} <= set(by_part):
            yield Command("drive", (by_part["forward"], by_part["turn"]), operation)
        elif len(values) == 2 and "to" in words(operation.name):
            yield Command("reach", (values[0], values[1]), operation)
        elif len(values) == 2 and any(word in DRIVES for word in (bare(operation.name), *words(operation.name))):
            yield Command("drive", (values[0], values[1]), operation)
        elif operation.kind == "method" and not values and words(operation.name)[0] in HALTS:
            yield Command("drive", (), operation)


def _follows(reading: Value, operation: Operation, is_alone: bool) -> Iterator[Command]:
    """How a reading follows an operation, as far as their names say it; `is_alone`: it is the device's only number."""
    values = list(told_values(operation))
    reads = f"{reading.name}_{reading.operation.name}"
    is_deed = reading.operation.kind == "method" and words(reading.operation.name)[0] in DEEDS
    if is_deed or {*words(reads)} & {*STORES}:
        return
    is_halt = operation.kind == "method" and not values and words(operation.name)[0] in HALTS
    if is_halt and reading.kind == "float":
        yield from (Command("speed", (), operation),) if is_alone else ()
    elif operation.kind == "method" and not values and _moves(operation.name, reads, is_alone):
        yield Command("up" if goes_up(operation.name, reading) else "down", (), operation)
    if len(values) != 1:
        return
    value = values[0]
    called = {*words(value.name), *words(operation.name)}
    is_named = bool(called & {*words(reads)} - _COMMON) or (is_alone and bool(called & {*GOES, *_OF_SPEED}))
    if value.kind == "bool" and (is_named or _moves(f"{value.name}_{operation.name}", reads, is_alone)):
        yield Command("switch", (value,), operation)
    elif value.kind in ("float", "") and reading.kind == "float" and is_named:
        yield Command("speed" if called & _OF_SPEED else "target", (value,), operation)


def _moves(command: str, reads: str, is_alone: bool) -> bool:
    """Whether a command of this name lets a reading go up or down: `open` of what says `is_open`, or one number."""
    pair, side = way(command)
    return bool(side) and (is_alone or (way(reads)[0] == pair and bool(way(reads)[1])))


_COMMON = {"is", "has", "state", "get", "status"}
"""Words that a reading and a command can share and have nothing to do with each other."""

_OF_SPEED = {"speed", "velocity", "rate"}


def goes_up(name: str, reading: Value) -> bool:
    """Whether a reading goes up, or is true, after a command of this name: `is_closed` after `close`."""
    side, reads = way(name)[1] or 1, way(f"{reading.name}_{reading.operation.name}")[1] or 1
    return side * reads > 0
