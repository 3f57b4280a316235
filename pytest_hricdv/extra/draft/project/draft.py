"""`Draft`: the names, values and times from which all files of a project are written, from the model of the code."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from pytest_hricdv.extra.draft.code.attributes import OBSERVED
from pytest_hricdv.extra.draft.code.naming import word
from pytest_hricdv.extra.draft.code_model import (
    CodeLine,
    CodeModel,
    Entry,
    Message,
    MessageField,
    Operation,
    Port,
    StateMachine,
)
from pytest_hricdv.extra.draft.project.answers import Answers
from pytest_hricdv.extra.draft.project.inputs import Input, number_levels, variants_of
from pytest_hricdv.extra.draft.ros_model import RosStart
from pytest_hricdv.skeleton.skeleton import name_like

MANNERS = ("in_time", "too_early", "too_late", "twice")
"""The manners of a person's acts; *never* is a belief without a command."""

ENDS = ("limit", "idle", "early", "cycle")
"""The ends of a run that a testbench can allow (`VirtualTime.allowed_endings`)."""

LATE_S, LATE_FOR_NODES_S = 30.0, 10.0
"""Least wait of a person who is too late; the timers of ROS 2 nodes make each simulated second expensive."""

MAX_LATE_S = 300.0
"""Longer time-outs are not waited for: a run would take long."""

MAX_LEVELS = 6
"""Most values to which a person sets a sensor."""


@dataclass(frozen=True)
class Sensor:
    """A bool, number or string that a device returns, as its class declares or the code uses it; a person sets it."""

    port: str
    operation: Operation
    field: MessageField
    left_out: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The name of its signal and its beliefs."""
        return self.path.replace(".", "_", 1).replace("()", "")

    @property
    def path(self) -> str:
        """Where stand-ins have it."""
        return self.operation.path(self.port)

    @property
    def levels(self) -> tuple[tuple[str, str], ...]:
        """Word for what a person can set -> the source text of its range, or the text itself."""
        return tuple(level for level in self._levels() if f"set_{word(self.name)} {level[0]}" not in self.left_out)

    def _levels(self) -> tuple[tuple[str, str], ...]:
        if self.field.kind == "bool":
            return (("yes", ""), ("no", ""))
        if self.field.kind == "str":
            texts = {word(value.text): value.text for value in self.field.values[:MAX_LEVELS]}
            return tuple(texts.items())
        if self.field.observed:
            low, high = self.field.observed
            middle = (low + high) / 2
            return (("low", f"Uniform({low:g}, {middle:g})"), ("high", f"Uniform({middle:g}, {high:g})"))
        if self.field.compared:
            return tuple((level, text) for level, _, text, _ in number_levels(self.field, boundaries=True))
        return (("low", "Uniform(0.0, 1.0)"), ("high", "Uniform(1.0, 2.0)"))


@dataclass(frozen=True)
class Draft:
    """The names and values of a draft's files.

    Args:
        declared: what is known of the code.
        robot: name of the project and of the robot.
        person: name of the person's agent.
        folder: where it is written.
        takes_time: whether each call of a device takes some simulated time; else a loop without a wait would not end.
        dropped: subjects of requirements that did not hold in the first runs.
        has_dropped_all: whether no requirement on what it publishes held: then one on the visit is left.
        ros: how the node of ROS 2 is started that the draft is for; None if it is for other code.
        sizes: suite -> its tests, where a draft's usual number of them takes too long.
        isolates: whether each test has a process of its own: one leaves a state of the code to the next.
        allowed_endings: how runs may end: all that is known where none was made, and as the first runs ended otherwise.
        working_folder: where the code runs, as it reads files there; empty: in that of the draft.
        taken_out: what first runs did without because it failed: "state", which is not looked at; "calls"; "entry", the
            code is only imported; "import", nor that; and names of messages that the testbench refuses.
        left_out: commands at which first runs raised an error.
        may_raise: names of errors at which the code ends, as it lacks a file, a connection or a module.
        audits: whether sessions run tests again to see whether they repeat; not where one did not.
        is_silent: whether the person only is there: what else it might do did not reach the code, or stopped it.
        missing: lines of the code that no first run executed, by file.
        earlier: the files of the last draft in the folder, with what somebody has changed in them.
    """

    declared: CodeModel
    robot: str
    person: str
    folder: Path
    takes_time: bool = False
    dropped: tuple[str, ...] = ()
    has_dropped_all: bool = False
    ros: RosStart | None = None
    sizes: Mapping[str, int] = field(default_factory=dict)
    isolates: bool = False
    allowed_endings: tuple[str, ...] = ENDS
    working_folder: str = ""
    taken_out: frozenset[str] = frozenset()
    left_out: tuple[str, ...] = ()
    may_raise: tuple[str, ...] = ()
    audits: bool = True
    is_silent: bool = False
    missing: Mapping[str, tuple[int, ...]] = field(default_factory=dict)
    earlier: Answers = field(default_factory=dict)

    @cached_property
    def code(self) -> CodeModel:
        """The model of the code without the parts that failed in first runs."""
        code, out = self.declared, self.taken_out
        if "entry" in out:
            return replace(code, entry=None, messages=(), machines=(), inner=())
        messages = [message for message in code.messages if message.name not in out]
        messages = [message for message in messages if message.form != "call" or "calls" not in out]
        if "state" in out:
            messages = [message for message in messages if message.form != "state"]
            code = replace(code, machines=tuple(replace(machine, field="") for machine in code.machines))
        return replace(code, messages=tuple(messages))

    @property
    def imports_code(self) -> bool:
        """Whether the code is imported; not where that alone raises."""
        return "import" not in self.taken_out

    @property
    def whole(self) -> Draft:
        """The draft with all that the code declares, also where it failed in first runs."""
        return replace(self, taken_out=frozenset(), left_out=(), is_silent=False)

    @property
    def entry(self) -> Entry | None:
        """The entry that is called."""
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
        """The messages that a person can say."""
        said = self.code.inputs if not self.is_silent else ()
        made = (variants_of(message).without(self.left_out) for message in said)
        return tuple(thing for thing in made if thing.variants)

    @cached_property
    def sensors(self) -> tuple[Sensor, ...]:
        """The known return values of devices."""
        every = (
            Sensor(port.name, operation, operation.result, self.left_out)
            for port in ((*self.devices, *self.code.inner) if not self.is_silent else ())
            if port.role == "device"
            for operation in port.operations
            if operation.result is not None and not operation.is_set
        )
        return tuple(sensor for sensor in every if sensor.levels)

    @cached_property
    def messages(self) -> tuple[Message, ...]:
        """All messages of the bus: what the code publishes, and what a person says."""
        said = [thing.message for thing in self.inputs]
        return tuple(message for message in self.code.messages if message.direction != "received" or message in said)

    @cached_property
    def answers(self) -> tuple[Message, ...]:
        """The robot's answers to people: its messages, or else its calls, or else its states."""
        state_topic = self.code.state.partition(".")[0]
        own = tuple(m for m in self.code.outputs if m.form not in ("called", "state") and m.topic != state_topic)
        called = tuple(message for message in self.code.outputs if message.form == "called")
        return own or called or self.code.outputs

    @property
    def tells_presence(self) -> bool:
        """Whether signals tell that the person is there, for a requirement where there is no other."""
        return self.has_dropped_all or not self.code.outputs or not self.inputs

    @property
    def is_alone(self) -> bool:
        """Whether nothing is known that a person could do with the robot, but to stay with it."""
        return not self.inputs and not self.sensors

    @property
    def hollow(self) -> str:
        """Why its tests say little; empty where people do something."""
        if not self.is_alone:
            return ""
        what = "the code runs while somebody is there" if self.entry is not None else "the code can be imported"
        what = what if self.imports_code else "pytest runs: not even the import of the code succeeds"
        return f"nothing that people do reaches the code, so its tests only show that {what}: see QUESTIONS.md"

    @property
    def machine(self) -> StateMachine | None:
        """The machine whose state the code publishes; else one that it declares; None without any."""
        return self.code.machine or next((machine for machine in self.code.machines if machine.states), None)

    @property
    def states(self) -> tuple[str, ...]:
        """The states of this machine."""
        return tuple(state.name for state in self.machine.states) if self.machine is not None else ()

    @property
    def has_open_states(self) -> bool:
        """Whether there may be other states."""
        return self.code.machine is not None and self.code.machine.kind == OBSERVED

    @property
    def transitions(self) -> tuple[tuple[str, str, CodeLine], ...]:
        """The transitions, without those that stay in a state."""
        moves = self.code.machine.transitions if self.code.machine is not None else ()
        return tuple((move.source, move.target, move.location) for move in moves if move.source != move.target)

    @property
    def late_s(self) -> tuple[float, CodeLine | None]:
        """The longest time-out of the code, with its location; None for the default."""
        fitting = [time_out for time_out in self.code.time_outs if 1.0 <= time_out[0] <= MAX_LATE_S]
        return max(fitting, key=lambda time_out: time_out[0], default=(self.patience_s, None))

    @property
    def patience_s(self) -> float:
        """The least wait of a person for an answer, also of one who is too late."""
        return LATE_S if self.ros is None else LATE_FOR_NODES_S

    @property
    def is_async(self) -> bool:
        """Whether the robot is a coroutine."""
        return self.entry is not None and self.entry.is_async

    @property
    def replacement_lines(self) -> list[str]:
        """The statement of a testbench that gives them their stand-ins; none if all is installed."""
        names = self.absent_modules
        return [f"    replace_modules({', '.join(map(json.dumps, names))})  # not installed here", ""] if names else []

    @property
    def absent_modules(self) -> tuple[str, ...]:
        """Modules that get a stand-in."""
        return tuple(
            problem.text.split("`")[1]
            for problem in self.code.problems
            if problem.kind == "missing module" and "`" in problem.text
        )


def robot_name(code: CodeModel) -> str:
    """A name for the project: the name of the entry's module, or of the package."""
    return name_like(code.package.rstrip("/").rpartition("/")[2].removesuffix(".py").rpartition(".")[2])
