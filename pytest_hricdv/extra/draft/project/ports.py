"""The ports of a draft: what the code gets instead of its hardware, its bus and its queues."""

from __future__ import annotations

import re

from pytest_hricdv.extra.draft.code.naming import camel
from pytest_hricdv.extra.draft.code_model import Operation, Port
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.templates import (
    ANYTHING,
    ASYNC_BUS,
    ASYNC_QUEUES,
    MISSING,
    OUTBOX,
    SYNC_BUS,
    SYNC_QUEUES,
)

_PUT = {True: "async def put(self, message: Any) -> None:",
        False: "def put(self, message: Any, *_: Any, **__: Any) -> None:"}  # fmt: skip
"""Whether the robot is a coroutine -> the head of a method."""


def ports(draft: Draft) -> str:
    """The module of the ports; without what this robot does not need."""
    roles = {port.role for port in draft.ports}
    bus = bus_class(draft)
    is_unknown = any(_is_unknown(operation) for port in draft.devices for operation in port.operations)
    parts = [ANYTHING] if draft.absent_modules or is_unknown else []
    parts += [MISSING] if draft.absent_modules else []
    if "queue" in roles or bus in ("async", "sync"):
        parts.append(ASYNC_QUEUES if draft.is_async else SYNC_QUEUES)
    if roles & {"queue", "publish"}:
        parts.append(OUTBOX.replace("{put}", _PUT[draft.is_async]))
    parts += {"async": [ASYNC_BUS], "sync": [SYNC_BUS]}.get(bus, [])
    parts += [_device(draft, port) for port in draft.devices]
    body = "".join(parts)
    return _head(draft, body) + body


def bus_class(draft: Draft) -> str:
    """Which bus the code has: "" (none), "own" (one like the plugin's), "async", or "sync" with more methods."""
    bus = next((port for port in draft.ports if port.role == "bus"), None)
    if bus is None:
        return ""
    if draft.is_async:
        return "async"
    has_callback = any(operation.name == "subscribe" and operation.arguments > 1 for operation in bus.operations)
    is_own = {operation.name for operation in bus.operations} <= {"publish", "subscribe"}
    return "own" if is_own and not has_callback else "sync"


def device_class(port: Port) -> str:
    """The name of a stand-in."""
    return camel(port.name.strip("_"))


def _device(draft: Draft, port: Port) -> str:
    """The stand-in of a port."""
    lines = []
    if port.name in draft.device_calls:
        calls = ", ".join(f'"{call}"' for call in draft.device_calls[port.name])
        doc = f'    """The robot has called `{port.name}`: its stand-in sends this."""'
        name = draft.classes_of_calls[port.name]
        lines += ["", "", "@dataclass(frozen=True)", f"class {name}:", doc, "", f"    what: Literal[{calls}]"]
    lines += [
        "",
        "",
        f"class {device_class(port)}:",
        f'    """Stand-in of `{port.name}` ({port.location}). TODO: what does it do, and what does it return?"""',
        "",
        "    def __init__(self, world: World) -> None:",
        "        self._world = world",
    ]
    set_there = [operation for operation in port.operations if operation.is_set]
    lines += [f"        self.{_holder(operation)}: Any = None  # {operation.location}" for operation in set_there]
    for operation in port.operations:
        if operation.name == "__call__" or not operation.name.startswith("__"):
            lines += _method(draft, port, operation) if operation.is_method else _attribute(draft, port, operation)
    return "\n".join(lines) + "\n"


def _holder(operation: Operation) -> str:
    """The attribute of a stand-in that keeps what the code sets."""
    return f"_{operation.name.strip('_')}_is"


def _attribute(draft: Draft, port: Port, operation: Operation) -> list[str]:
    """An attribute of a stand-in: what the code reads, or sets."""
    name = operation.name
    head = ["", "    @property", f"    def {name}(self) -> Any:", f'        """{operation.location}"""']
    if not operation.is_set:
        return [*head, *_return_lines(draft, port, operation)]
    lines = [*head, f"        return self.{_holder(operation)}", "", f"    @{name}.setter"]
    return [*lines, f"    def {name}(self, value: Any) -> None:", f"        self.{_holder(operation)} = value"]


def _method(draft: Draft, port: Port, operation: Operation) -> list[str]:
    """A method of a stand-in; that it was called is recorded, unless it reads a sensor."""
    a = "async " if operation.is_async else ""
    lines = ["", f"    {a}def {operation.name}(self, *_: Any, **__: Any) -> Any:"]
    lines += [f'        """{operation.location}"""']
    if draft.takes_time and not operation.is_async:
        lines.append("        self._world.sleep(STEP_S)")
    call = operation.name.strip("_")
    if call in draft.device_calls.get(port.name, ()):
        lines.append(f'        self._world.record("{port.name}_did", "{call}")')
        lines.append(f'        self._world.called("{port.name}", {draft.classes_of_calls[port.name]}("{call}"))')
    return [*lines, *_return_lines(draft, port, operation)]


def _return_lines(draft: Draft, port: Port, operation: Operation) -> list[str]:
    """The lines that return a value: of a sensor, or a neutral one."""
    sensor = next((s for s in draft.sensors if (s.port, s.operation.name) == (port.name, operation.name)), None)
    if sensor is not None:
        return [f'        return self._world.senses["{sensor.name}"]']
    value = operation.neutral or ("Anything()" if _is_unknown(operation) else "None")
    imports = [f"        from {module} import {name}" for module, name in operation.imports]
    return [*imports, f"        return {value}  # TODO"]


def _is_unknown(operation: Operation) -> bool:
    return not (operation.is_set or operation.neutral)


def _head(draft: Draft, body: str) -> str:
    """The imports and constants that the classes need."""
    lines = [
        '"""What the code gets instead of its hardware, its bus and its queues. Replace it part by part."""',
        "",
        "from __future__ import annotations",
        "",
    ]
    lines += [f"import {name}" for name in ("asyncio", "queue", "sys") if re.search(rf"(?<![\w.]){name}\.", body)]
    names = [name for name in ("Callable", "Iterator") if re.search(rf"\b{name}\[", body)]
    lines += [f"from collections.abc import {', '.join(names)}"] if names else []
    lines += ["from dataclasses import dataclass"] if "@dataclass(" in body else []
    lines += ["from functools import partial"] if "partial(" in body else []
    if draft.absent_modules:
        lines += ["from importlib.abc import Loader, MetaPathFinder", "from importlib.machinery import ModuleSpec"]
    types = [name for name in ("FunctionType", "ModuleType") if re.search(rf"\b{name}\b", body)]
    lines += [f"from types import {', '.join(types)}"] if types else []
    typed = [name for name in ("Any", "Literal", "Self") if re.search(rf"\b{name}\b", body)]
    lines += [f"from typing import {', '.join(typed)}"] if typed else []
    own = ["from pytest_hricdv.runtime import is_message"] if "is_message(" in body else []
    own += ["from pytest_hricdv.testbench import Run"] if re.search(r"\bRun\b", body) else []
    if re.search(r"\bWorld\b", body):
        own += ["", "from world import World"] if own else ["from world import World"]
    lines += [*([""] if own else []), *own]
    if draft.absent_modules:
        missing = ", ".join(
            f'"{name}"' for name in dict.fromkeys(name.partition(".")[0] for name in draft.absent_modules)
        )
        lines += ["", f"MISSING = ({missing},)"]
    constants = {
        "REST_OF_RUN_S": "10_000.0  # longer than any run",
        "LOOKS_EACH_S": "0.02",
        "STEP_S": "0.01  # time that each call of a device takes: a loop that only asks devices would not end",
    }
    used = [f"{name} = {value}" for name, value in constants.items() if re.search(rf"\b{name}\b", body)]
    return "\n".join([*lines, *([""] if used else []), *used]) + "\n"


# --- the world

_INITIAL = {"bool": "False", "float": "0.0", "str": '""'}

_WORLD = '''

class World:
    """The world of a run. Replace it by your simulator; TODO: what moves, and what do sensors return then?"""

    def __init__(self, kernel: Kernel, recorder: Recorder{bus}) -> None:
        self._kernel, self._recorder = kernel, recorder
{calls}        self.senses: dict[str, bool | float] = dict(SENSES)
        for name, value in (*INITIAL.items(), *SENSES.items()):
            self.record(name, value)

    def record(self, name: str, value: bool | float | str) -> None:
        """Record a signal."""
        self._recorder.signal(self._kernel.now_s, name, value)

{called}    def sense(self, name: str, value: bool | float) -> None:
        """From now on a sensor returns this."""
        self.senses[name] = value
        self.record(name, value)

    def sleep(self, duration_s: float) -> None:
        """Let simulated time pass."""
        self._kernel.sleep(duration_s)
'''

_CALLED = '''    def called(self, name: str, message: Any) -> None:
        """Tell others that a device was called. The same call in a loop, as every 0.1 s, is told once."""
        before, now_s = self._calls.get(name), self._kernel.now_s
        self._calls[name] = (message, now_s)
        if before is None or before[0] != message or not 0.0 < now_s - before[1] <= REPEATS_S:
            self._bus.port(name).publish(message)

'''


def world(draft: Draft) -> str:
    """The module of the world."""
    lines = [
        '"""The world: a signal for each field that the robot publishes, and for each sensor that it reads."""',
        "",
        "from __future__ import annotations",
        "",
        *(["from typing import Any", ""] if draft.device_calls else []),
        f"from pytest_hricdv.runtime import {'Bus, ' if draft.device_calls else ''}Kernel, Recorder",
        *(
            ["", "REPEATS_S = 1.0  # a call that comes again within this time is told once; TODO"]
            if draft.device_calls
            else []
        ),
        "",
        "# What the code reads at its ports, and what it reads first. TODO: what is right for your robot?",
        "SENSES: dict[str, bool | float] = {",
    ]
    lines += [f'    "{s.name}": {_INITIAL[s.kind]},  # {s.operation.location}' for s in draft.sensors]
    lines += ["}", "", "# The fields that the robot publishes, before it has published any."]
    lines.append("INITIAL: dict[str, bool | float | str] = {")
    lines += [f'    "{signal.name}": {_INITIAL[signal.kind]},  # {signal.location}' for signal in draft.signals]
    if draft.tells_presence:
        lines += ['    "person_is_there": True,', '    "robot_works": True,']
    lines += [
        f'    "{port.name}_did": "",  # {port.location}' for port in draft.devices if port.name in draft.device_calls
    ]
    lines += ["}", "", "SIGNALS: dict[str, type[bool | float | str]] = {"]
    lines += ["    name: type(value) for name, value in (*INITIAL.items(), *SENSES.items())", "}"]
    text = _WORLD.replace("{called}", _CALLED if draft.device_calls else "").replace(
        "{bus}", ", bus: Bus" if draft.device_calls else ""
    )
    calls = (
        "        self._bus = bus\n        self._calls: dict[str, tuple[Any, float]] = {}\n"
        if draft.device_calls
        else ""
    )
    return "\n".join(lines) + "\n" + text.replace("{calls}", calls)
