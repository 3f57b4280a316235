"""What a draft is made of: the names, values and times of all its files, computed once from the model of the code."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from pytest_hricdv.extra.draft.code.naming import camel
from pytest_hricdv.extra.draft.code_model import (
    CodeLine,
    CodeModel,
    Entry,
    Message,
    Operation,
    Port,
)
from pytest_hricdv.extra.draft.observed import Observation
from pytest_hricdv.extra.draft.project.inputs import Input, variants_of
from pytest_hricdv.extra.draft.ros_model import RosStart
from pytest_hricdv.skeleton.skeleton import name_like

MANNERS = ("in_time", "too_early", "too_late", "twice")
"""How a person does something; *never* is a belief without a command."""

ENDS = ("limit", "idle", "early", "cycle")
"""How a run may end, of `VirtualTime.allowed_endings`."""

LATE_S, LATE_FOR_NODES_S = 30.0, 10.0
"""How long a person waits at least who is too late; the timers of nodes of ROS 2 make each simulated second dear."""

MAX_LATE_S = 300.0
"""Longer time-outs are not waited for: a run would take long."""


@dataclass(frozen=True)
class Sensor:
    """A truth or a number that a device returns, as its class in the code declares."""

    port: str
    operation: Operation
    name: str
    kind: str


@dataclass(frozen=True)
class FieldSignal:
    """A signal that the world records: a field of a published message."""

    name: str
    kind: str
    topic: str
    field: str
    location: CodeLine


@dataclass(frozen=True)
class Draft:
    """The names and values of a draft's files.

    Args:
        code: what is known of the code.
        robot: name of the project and of the robot.
        person: name of the person's agent.
        folder: where it is written.
        takes_time: whether each call of a device takes some simulated time; else a loop without a wait would not end.
        dropped: subjects of requirements that did not hold in the first runs.
        untriggered: id of a requirement that some first runs triggered -> the suite in which none did.
        has_dropped_all: whether no requirement on what it publishes held: then one on the visit is left.
        ros: how the node of ROS 2 is started that the draft is for; None where it is for other code.
        observed: what recordings of the real system show; None without them.
        sizes: suite -> its tests, where a draft's usual number of them takes too long.
        has_others: whether a person also says a text that the code does not know; not where it raises then.
        no_waivers: where first runs executed what the code waives as unreachable, `file:line`; empty: nowhere.
        isolates: whether each test has a process of its own: one leaves a state of the code to the next.
        allowed_endings: how runs may end: all that is known where none was made, and as the first runs ended otherwise.
    """

    code: CodeModel
    robot: str
    person: str
    folder: Path
    takes_time: bool = False
    dropped: tuple[str, ...] = ()
    has_dropped_all: bool = False
    untriggered: Mapping[str, str] = field(default_factory=dict)
    ros: RosStart | None = None
    observed: Observation | None = None
    sizes: Mapping[str, int] = field(default_factory=dict)
    has_others: bool = True
    no_waivers: str = ""
    isolates: bool = False
    allowed_endings: tuple[str, ...] = ENDS

    @property
    def entry(self) -> Entry | None:
        """What is called."""
        return self.code.entry

    @property
    def ports(self) -> tuple[Port, ...]:
        """All parameters of the entry, those of its method last."""
        return (*self.entry.ports, *self.entry.method_ports) if self.entry is not None else ()

    @property
    def devices(self) -> tuple[Port, ...]:
        """The ports that are stand-ins of hardware."""
        return tuple(port for port in self.ports if port.role == "device" and not port.default)

    @property
    def parameters(self) -> tuple[Port, ...]:
        """Numbers that are drawn for each run."""
        return tuple(
            port
            for port in self.ports
            if port.role == "parameter" and not port.default and port.annotation in ("", "float", "int")
        )

    @cached_property
    def inputs(self) -> tuple[Input, ...]:
        """What a person can say."""
        return tuple(variants_of(message, self.has_others) for message in self.code.inputs)

    @cached_property
    def sensors(self) -> tuple[Sensor, ...]:
        """Truths and numbers that devices return, as far as their classes declare it."""
        kinds = {"bool": "bool", "float": "float", "int": "float"}
        return tuple(
            Sensor(port.name, operation, f"{port.name}_{operation.name}", kinds[operation.returns])
            for port in self.devices
            for operation in port.operations
            if operation.returns in kinds and not operation.is_set
        )

    @property
    def device_calls(self) -> dict[str, tuple[str, ...]]:
        """Port -> the methods that the code calls on the device, without those that read a sensor."""
        sensors = {(sensor.port, sensor.operation.name) for sensor in self.sensors}
        calls = {
            port.name: tuple(
                operation.name.strip("_")
                for operation in port.operations
                if operation.is_method and (port.name, operation.name) not in sensors
                if not operation.name.startswith("__") or operation.name == "__call__"
            )
            for port in self.devices
        }
        return {port: tuple(dict.fromkeys(names)) for port, names in calls.items() if names}

    @property
    def classes_of_calls(self) -> dict[str, str]:
        """Port -> the name of the message that its stand-in sends when it is called."""
        taken = {message.name for message in self.code.messages}
        names = {port: f"{camel(port.strip('_'))}Called" for port in self.device_calls}
        return {port: f"{name}OfDevice" if name in taken else name for port, name in names.items()}

    @cached_property
    def signals(self) -> tuple[FieldSignal, ...]:
        """One for each field that the robot publishes."""
        return tuple(
            FieldSignal(f"said_{message.topic}_{part.name}", part.kind, message.topic, part.name, part.location)
            for message in self.code.outputs
            for part in message.fields
            if part.kind
        )

    @property
    def messages(self) -> tuple[Message, ...]:
        """All messages of the bus, by their names."""
        return tuple(sorted(self.code.messages, key=lambda message: message.name))

    @cached_property
    def answers(self) -> tuple[Message, ...]:
        """What the robot tells people: all but its states, unless it publishes nothing else."""
        states = self.code.state.partition(".")[0]
        others = tuple(message for message in self.code.outputs if message.topic != states)
        return others or self.code.outputs

    @property
    def tells_presence(self) -> bool:
        """Whether signals tell that the person is there, for a requirement where there is no other."""
        return self.has_dropped_all or not self.code.outputs or not self.inputs

    @property
    def is_alone(self) -> bool:
        """Whether nothing is known that a person could do with the robot, but to stay with it."""
        return not self.inputs and not self.sensors

    @property
    def states(self) -> tuple[str, ...]:
        """The states that the code publishes."""
        return tuple(state.name for state in self.code.machine.states) if self.code.machine is not None else ()

    @property
    def transitions(self) -> tuple[tuple[str, str, CodeLine], ...]:
        """From state to state, without those that lead nowhere else."""
        moves = self.code.machine.transitions if self.code.machine is not None else ()
        return tuple((move.source, move.target, move.location) for move in moves if move.source != move.target)

    @property
    def late_s(self) -> tuple[float, CodeLine | None]:
        """The longest time-out of the code, with its location; None for the default."""
        waits = [(wait.seconds, wait.location) for wait in self.code.waits if wait.bounded and wait.seconds]
        waits += [(c.value, c.location) for c in self.code.constants if c.unit == "s"]
        fitting = [(seconds, at) for seconds, at in waits if seconds is not None and seconds <= MAX_LATE_S]
        longest = max(fitting, key=lambda wait: wait[0], default=None)
        return (longest[0], longest[1]) if longest is not None and longest[0] >= 1.0 else (self.patience_s, None)

    @property
    def patience_s(self) -> float:
        """How long a person waits at least for an answer, and who is too late."""
        return LATE_S if self.ros is None else LATE_FOR_NODES_S

    @property
    def is_async(self) -> bool:
        """Whether the robot is a coroutine."""
        return self.entry is not None and self.entry.is_async

    @property
    def absent_modules(self) -> tuple[str, ...]:
        """Modules that get a stand-in."""
        return tuple(
            problem.text.split("`")[1]
            for problem in self.code.problems
            if problem.kind == "missing module" and "`" in problem.text
        )


def robot_name(code: CodeModel) -> str:
    """A name for the project: that of the entry's module, or of the package."""
    return name_like(code.package.rstrip("/").rpartition("/")[2].removesuffix(".py").rpartition(".")[2])


# --- source text


WIDTH = 88
"""Longer imports are one name a line, as ruff has them where nothing else is configured."""


def import_lines(draft: Draft, imports: Iterable[tuple[str, str]]) -> list[str]:
    """Imports, sorted; those of the draft apart where the code is in another folder."""
    by_module: dict[str, list[str]] = {}
    for module, name in imports:
        if name not in by_module.setdefault(module, []):
            by_module[module].append(name)
    lines = {module: _import(module, sorted(by_module[module])) for module in sorted(by_module)}
    groups = [[module for module in lines if (module in ("ports", "world")) == is_own] for is_own in (False, True)]
    if draft.code.root == str(draft.folder) or not all(groups):
        return list(lines.values())
    return [*(lines[module] for module in groups[0]), "", *(lines[module] for module in groups[1])]


def _import(module: str, names: Sequence[str]) -> str:
    line = f"    from {module} import {', '.join(names)}"
    if len(line) <= WIDTH:
        return line
    return "\n".join([f"    from {module} import (", *(f"        {name}," for name in names), "    )"])


def message_imports(messages: Iterable[Message]) -> list[tuple[str, str]]:
    """Module and name of each class."""
    return [(message.module, message.name) for message in messages]


def tuple_text(names: Iterable[str]) -> str:
    """Source text of a tuple of texts."""
    listed = [json.dumps(name, ensure_ascii=False) for name in names]
    return "(" + ", ".join(listed) + ("," if len(listed) == 1 else "") + ")"
