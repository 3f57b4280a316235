"""What a draft's devices say and are told: a signal each, and what somebody can make a sensor say."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from pytest_hricdv.extra.draft.found.port import Operation, Port
from pytest_hricdv.extra.draft.reading.neutral import FAR
from pytest_hricdv.extra.draft.surroundings.motion_words import is_open_first
from pytest_hricdv.extra.draft.surroundings.motions import Motion, Value, motions, readings, told_values

MOST_PARTS = 3
"""An object with more numbers and switches is no sensor: each of them would be a belief (chosen)."""

NEAR = (0.2, 1.0)
"""What all numbers of a tuple are where they are low: of a scan, somebody is near (chosen)."""


@dataclass(frozen=True)
class Sensor:
    """A value that the code reads at a port.

    Args:
        port: name of the port.
        operation: the method or attribute.
        name: of the attribute of the world, and of the signal.
        kind: "bool" or "float".
        low: range of the lower values (bool: none).
        high: range of the higher ones.
        is_certain: whether the code compares it with a number, from which the ranges are made.
        part: the number of the part of what is read; None where it has none.
        is_many: whether it stands for all numbers of a tuple.
        motion: what it follows; None where somebody has to say what it says.
    """

    port: str
    operation: Operation
    name: str
    kind: str
    low: tuple[float, float] = (0.0, 1.0)
    high: tuple[float, float] = (1.0, 2.0)
    is_certain: bool = False
    part: int | None = None
    is_many: bool = False
    motion: Motion | None = None

    @property
    def first(self) -> str:
        """Source text of what it says first."""
        if self.kind == "bool":
            return "False"
        if self.motion is not None:
            return repr(self.ends[1 if is_open_first(f"{self.port}_{self.name}") else 0])
        is_high = self.is_many or self.operation.usual == "high"
        return repr(round(self.high[1] if self.is_many else self.high[0] if is_high else self.low[1], 6))

    @property
    def ends(self) -> tuple[float, float]:
        """Between which numbers it goes, if it follows something: beyond those that the code compares it with."""
        compared = self.motion.readings[0].compared if self.motion is not None else ()
        if all(0.0 <= number <= 1.0 for number in compared):
            return 0.0, 1.0
        return self.low[0], self.high[1]


@dataclass(frozen=True)
class Told:
    """Something that the code tells a device: an argument of a call, or what it sets an attribute to.

    `signal` records it, of this kind; texts stand for what is of no kind that the code says. `part` is the field of the
    argument, empty where it is the argument itself.
    """

    port: str
    operation: Operation
    argument: str
    signal: str
    kind: str
    part: str = ""


def motions_of(devices: Sequence[Port]) -> dict[str, tuple[Motion, ...]]:
    """Port -> what moves of it, where something does."""
    found = {port.name: motions(port) for port in devices}
    return {name: moving for name, moving in found.items() if moving}


def sensors_of(devices: Sequence[Port]) -> Iterator[Sensor]:
    """What the code reads at its devices, but for where they are."""
    for port in devices:
        moving = motions(port)
        poses = [value for motion in moving if motion.is_pose for value in motion.readings]
        for operation in port.operations:
            values = [value for value in readings(port) if value.operation is operation and value not in poses]
            values = [value for value in values if value.kind != "str"]
            if len(values) > MOST_PARTS:
                continue
            for value in (value for value in values if value.kind):
                motion = next((motion for motion in moving if value in motion.readings), None)
                yield _sensor(port, value, motion)


def _sensor(port: Port, value: Value, motion: Motion | None) -> Sensor:
    operation, compared = value.operation, value.compared
    name = f"{port.name}_{operation.name}"
    if value.part is not None:
        name += f"_{value.name or value.part + 1}"
    kind = "bool" if value.kind == "bool" else "float"
    low, high, is_certain = (0.0, 1.0), (1.0, 2.0), False
    if value.kind == "floats":
        low, high = NEAR, (float(FAR) / 2, float(FAR))
    elif kind == "float" and compared:
        least, most, is_certain = min(compared), max(compared), True
        width = abs(least) or 1.0
        low, high = (least - width, least - width / 4), (most + width / 4, most + width)
    return Sensor(port.name, operation, name, kind, low, high, is_certain, value.part, value.kind == "floats", motion)


def told_of(devices: Sequence[Port], sensors: Sequence[Sensor]) -> tuple[Told, ...]:
    """What the code tells its devices."""
    sensed = {(sensor.port, sensor.operation.name) for sensor in sensors}
    made: dict[str, Told] = {}
    for port in devices:
        for operation in port.operations:
            if (port.name, operation.name) in sensed:
                continue
            for value in told_values(operation):
                if value.part is not None and value.kind not in ("bool", "float", "str"):
                    continue
                argument = operation.arguments[value.index] if operation.kind == "method" else ""
                part = value.name if value.part is not None else ""
                signal = _signal(port.name, operation.name, argument, part)
                made.setdefault(signal, Told(port.name, operation, argument, signal, value.kind or "str", part))
    return tuple(made.values())


def _signal(*names: str) -> str:
    """The name of a signal; a word that comes again is said once: `gripper_command_close`."""
    parts = [name.strip("_").lower() for name in names]
    return "_".join(part for number, part in enumerate(parts) if part and part not in parts[:number])
