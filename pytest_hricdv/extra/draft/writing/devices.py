"""Stand-ins of devices, as text: what they are told is recorded, and what they say is a sensor, or follows it."""

from __future__ import annotations

from pytest_hricdv.extra.draft.found.port import Operation, Port
from pytest_hricdv.extra.draft.reading.naming import camel, unit_of
from pytest_hricdv.extra.draft.reading.neutral import FAR, MANY
from pytest_hricdv.extra.draft.surroundings.motions import Command, Motion, Value, goes_up
from pytest_hricdv.extra.draft.surroundings.sensing import Sensor, Told
from pytest_hricdv.extra.draft.writing.drafted import Draft
from pytest_hricdv.extra.draft.writing.templates.motions import DRIVE, MOVING, REACH, WHEELS


def device_class(port: Port) -> str:
    """The name of a stand-in."""
    return camel(port.name.strip("_"))


def called_classes(draft: Draft) -> dict[str, str]:
    """Port -> the name of the message that its stand-in sends when it is called."""
    taken = {message.name for message in draft.findings.messages}
    names = {port: f"{camel(port.strip('_'))}Called" for port in draft.called}
    return {port: f"{name}OfDevice" if name in taken else name for port, name in names.items()}


def has_unknowns(port: Port) -> bool:
    """Whether the stand-in returns something of which nothing is known."""
    return any(_is_unknown(operation) for operation in port.operations)


def _is_unknown(operation: Operation) -> bool:
    is_known = operation.made or operation.returns in ("bool", "float", "int", "text", "str", "None")
    in_part = any(part.made == "Anything()" for part in operation.parts)
    return in_part or not (operation.is_set or is_known or operation.parts)


def moving_classes(draft: Draft) -> str:
    """The classes of what moves."""
    moving = [motion for motions in draft.motions.values() for motion in motions]
    kinds = {command.kind for motion in moving for command in motion.commands}
    text = DRIVE if any(motion.is_pose for motion in moving) else ""
    text += (WHEELS if "wheels" in kinds else "") + (REACH if "reach" in kinds else "")
    return text + (MOVING if any(not motion.is_pose for motion in moving) else "")


def device(draft: Draft, port: Port) -> str:
    """The stand-in of a port."""
    lines = _called_message(draft, port)
    lines += [
        "",
        "",
        f"class {device_class(port)}:",
        f'    """Stand-in of `{port.name}` ({port.place}). TODO: what does it do, and what does it say?"""',
        "",
        "    def __init__(self, world: World) -> None:",
        "        self._world = world",
    ]
    for motion in draft.motions.get(port.name, ()):
        sensor = _sensor_of(draft, motion)
        made = f'Drive(world, "{port.name}")'
        if sensor is not None:
            made = f'Moving(world, "{sensor.name}", {sensor.ends[0]:g}, {sensor.ends[1]:g})'
        follows = ", ".join(dict.fromkeys(f"`{command.operation.name}`" for command in motion.commands))
        lines.append(f"        self.{_holder(draft, motion)} = {made}  # TODO: does it follow {follows}?")
    is_held = [operation for operation in port.operations if operation.kind == "attribute" and operation.is_set]
    lines += [f"        self.{_held(operation)}: Any = None  # {operation.place}" for operation in is_held]
    for operation in port.operations:
        if operation.name.startswith("__") and operation.name != "__call__":
            continue
        if operation.kind == "attribute":
            lines += _attribute(draft, port, operation)
        else:
            lines += _method(draft, port, operation)
    return "\n".join(lines) + "\n"


def _called_message(draft: Draft, port: Port) -> list[str]:
    """The message that tells that the robot has called the device."""
    if port.name not in draft.called:
        return []
    name = called_classes(draft)[port.name]
    calls = ", ".join(f'"{call}"' for call in draft.called[port.name])
    doc = f'    """The robot has called `{port.name}`: the stand-in says so."""'
    return ["", "", "@dataclass(frozen=True)", f"class {name}:", doc, "", f"    what: Literal[{calls}]"]


def _held(operation: Operation) -> str:
    """The attribute of a stand-in that keeps what the code sets."""
    return f"_{operation.name.strip('_')}_is"


def _attribute(draft: Draft, port: Port, operation: Operation) -> list[str]:
    """An attribute of a stand-in: what the code reads, or sets, which is recorded."""
    head = ["", "    @property", f"    def {operation.name}(self) -> Any:", f'        """{operation.place}"""']
    if not operation.is_set:
        return [*head, *_returned(draft, port, operation)]
    lines = [*head, f"        return self.{_held(operation)}", "", f"    @{operation.name}.setter"]
    lines += [f"    def {operation.name}(self, value: Any) -> None:", f"        self.{_held(operation)} = value"]
    lines += [f"        self._world.told({part.signal}=value)" for part in _told(draft, port, operation)]
    return lines + _moved(draft, port, operation)


def _method(draft: Draft, port: Port, operation: Operation) -> list[str]:
    """A method of a stand-in; what it is told is recorded."""
    told = _told(draft, port, operation)
    names = dict.fromkeys(part.argument for part in told)
    names |= dict.fromkeys(
        _argument(value) for command in _commands(draft, port, operation) for value in command.values
    )
    arguments = "".join(f", {name}: Any = None" for name in names)
    a = "async " if operation.is_async else ""
    lines = [
        "",
        f"    {a}def {operation.name}(self{arguments}, *_: Any, **__: Any) -> Any:",
        f'        """{operation.place}"""',
    ]
    if draft.takes_time and not operation.is_async:
        lines.append("        self._world.sleep(STEP_S)")
    if not _sensors(draft, port, operation) and not _is_pose(draft, port, operation):
        did = operation.name.strip("_")
        lines.append(f'        self._world.record("{port.name}_did", "{did}")')
        lines.append(f'        self._world.called("{port.name}", {called_classes(draft)[port.name]}("{did}"))')
    if told:
        lines.append(f"        self._world.told({', '.join(f'{part.signal}={_said(part)}' for part in told)})")
    return [*lines, *_moved(draft, port, operation), *_returned(draft, port, operation)]


def _told(draft: Draft, port: Port, operation: Operation) -> list[Told]:
    return [part for part in draft.told if (part.port, part.operation.name) == (port.name, operation.name)]


def _said(part: Told) -> str:
    """The source text of what is told."""
    return f'getattr({part.argument}, "{part.part}", None)' if part.part else part.argument


def _argument(value: Value) -> str:
    """The name of the argument of a command."""
    return value.operation.arguments[value.index] if value.operation.kind == "method" else "value"


def _commands(draft: Draft, port: Port, operation: Operation) -> list[Command]:
    """What moves by an operation."""
    moving = draft.motions.get(port.name, ())
    return [command for motion in moving for command in motion.commands if command.operation is operation]


def _sensor_of(draft: Draft, motion: Motion) -> Sensor | None:
    """The sensor that says where something is that moves; None of a pose."""
    return next((sensor for sensor in draft.sensors if sensor.motion == motion), None)


def _holder(draft: Draft, motion: Motion) -> str:
    """The attribute of a stand-in that moves."""
    sensor = _sensor_of(draft, motion)
    return "_drive" if sensor is None else f"_{sensor.name}"


def _moved(draft: Draft, port: Port, operation: Operation) -> list[str]:
    """The lines by which something moves."""
    lines = []
    for motion in draft.motions.get(port.name, ()):
        holder = f"        self.{_holder(draft, motion)}"
        for command in (command for command in motion.commands if command.operation is operation):
            values = [_value_of(value) for value in command.values]
            values += ["in_degrees=True"] if any(unit_of(value.name) == "deg/s" for value in command.values) else []
            if command.kind == "switch":
                up = goes_up(f"{command.values[0].name}_{operation.name}", motion.readings[0])
                lines.append(f"{holder}.switch({values[0] if up else f'not {values[0]}'})")
            else:
                method = {"drive": "go", "wheels": "go_by_wheels", "reach": "go_to", "target": "go"}.get(
                    command.kind, command.kind
                )
                lines.append(f"{holder}.{method}({', '.join(values)})")
    return lines


def _value_of(value: Value) -> str:
    """The source text of the value of a command."""
    argument = _argument(value)
    if value.part is None:
        return argument
    return f"{argument}.{value.name}" if value.name else f"{argument}[{value.part}]"


def _sensors(draft: Draft, port: Port, operation: Operation) -> list[Sensor]:
    """The sensors that an operation reads."""
    return [sensor for sensor in draft.sensors if (sensor.port, sensor.operation.name) == (port.name, operation.name)]


def _is_pose(draft: Draft, port: Port, operation: Operation) -> bool:
    """Whether an operation says where the device is."""
    return any(motion.is_pose and any(value.operation is operation for value in motion.readings)
               for motion in draft.motions.get(port.name, ()))  # fmt: skip


def _returned(draft: Draft, port: Port, operation: Operation) -> list[str]:
    """The lines that return a value."""
    said = {sensor.part: _now(sensor) for sensor in _sensors(draft, port, operation)}
    for motion in draft.motions.get(port.name, ()):
        for number, reading in enumerate(motion.readings if motion.is_pose else ()):
            if reading.operation is operation:
                text = f"self._drive.pose()[{number}]"
                said[reading.part] = f"degrees({text})" if unit_of(reading.name) == "deg" else text
    value = said.get(None) or _composed(operation, {part: text for part, text in said.items() if part is not None})
    todo = "" if said else "  # TODO"
    return [
        *(f"        from {module} import {name}" for module, name in operation.needs),
        f"        return {value}{todo}",
    ]


def _now(sensor: Sensor) -> str:
    """The source text of what a sensor says; of many numbers, those in the middle: of a scan, what is ahead."""
    if sensor.motion is not None:
        return f"self._{sensor.name}.now()"
    text = f'self._world.senses["{sensor.name}"]'
    if not sensor.is_many or sensor.part is None:
        return text
    is_tuple = sensor.operation.parts[sensor.part].made.startswith("(")
    far, near = (f"({FAR},)", f"({text},)") if is_tuple else (f"[{FAR}]", f"[{text}]")
    third = MANY // 3
    return f"{far} * {third} + {near} * {third} + {far} * {third}"


def _composed(operation: Operation, said: dict[int, str]) -> str:
    """The source text of what an operation returns, with these parts."""
    is_tuple = operation.made.startswith("(") or not operation.made
    if not said and not (is_tuple and operation.parts):
        return _neutral(operation)
    parts = [(part.name, said.get(number, part.made)) for number, part in enumerate(operation.parts)]
    if is_tuple:
        return "(" + "".join(f"{text}, " for _, text in parts).rstrip() + ")"
    return f"{operation.made.partition('(')[0]}({', '.join(f'{name}={text}' for name, text in parts if text)})"


def _neutral(operation: Operation) -> str:
    if operation.made:
        return operation.made
    if operation.returns in ("text", "str"):
        return '""'
    return "Anything()" if _is_unknown(operation) else "None"
