"""What a draft is made of: the names, values and times of all its files, computed once from the findings."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from pathlib import Path

from pytest_hricdv.extra.draft.found.findings import Entry, Findings, Message, MessageField, Place, Port
from pytest_hricdv.extra.draft.found.nodes import RosStart
from pytest_hricdv.extra.draft.reading.naming import word
from pytest_hricdv.extra.draft.surroundings.motions import Motion
from pytest_hricdv.extra.draft.surroundings.sensing import Sensor, Told, motions_of, sensors_of, told_of
from pytest_hricdv.extra.recordings.observed import Observed
from pytest_hricdv.skeleton.skeleton import name_like

MANNERS = ("in_time", "too_early", "too_late", "twice")
"""How a person does something; *never* is a belief without a command."""

MOST_KINDS = 12
"""If messages of one class have more combinations of values, not all of them are drafted (chosen: three switches, or
four texts with a number that is low, usual or high)."""

ENDS = ("limit", "idle", "early", "cycle")
"""How a run may end, of `Testbench.may_end`."""

OTHER = "something else"
"""A text that no code knows."""

LATE_S = 30.0
"""How long a person waits at least who is too late, where the code has no time-out (chosen)."""

LATE_FOR_NODES_S = 10.0
"""The same where the code is a node of ROS 2 (chosen: its timers make each simulated second dear)."""

MOST_LATE_S = 300.0
"""Longer time-outs are not waited for: a run would take long (chosen)."""


@dataclass(frozen=True)
class Kind:
    """A message as a person says it.

    Args:
        name: the word in the model, and in commands; empty where there is one only.
        values: source text of each field that has a value of its own.
        place: where the value is in the code.
        ranges: source text of the range of each number that the code compares with others.
        is_usual: whether the code knows its text, and its numbers are usual where it has one.
    """

    name: str
    values: tuple[tuple[str, str], ...]
    place: Place
    ranges: tuple[tuple[str, str], ...] = ()
    is_usual: bool = True


@dataclass(frozen=True)
class Thing:
    """Something that the robot can hear."""

    message: Message
    name: str
    kinds: tuple[Kind, ...]
    numbers: tuple[MessageField, ...]

    @property
    def commands(self) -> tuple[tuple[str, Kind], ...]:
        """The name of each command, with what it says."""
        return tuple((f"{self.name}_{kind.name}".strip("_"), kind) for kind in self.kinds)


@dataclass(frozen=True)
class Signal:
    """A signal that the world records, with its kind and where the value is said."""

    name: str
    kind: str
    topic: str
    field: str
    place: Place


@dataclass(frozen=True)
class Draft:
    """The names and values of a draft's files.

    Args:
        findings: what was found.
        robot: name of the project and of the robot.
        person: name of the person's agent.
        folder: where it is written.
        takes_time: whether each call of a device takes some simulated time; else a loop without a wait would not end.
        dropped: subjects of requirements that did not hold in the first runs.
        untriggered: id of a requirement that some first runs triggered -> the suite in which none did.
        has_dropped_all: whether none of what it says held: then a requirement on the visit is left.
        ros: how the node of ROS 2 is started that the draft is for; None where it is for other code.
        observed: what recordings of the real system show; None without them.
        sizes: suite -> its tests, where a draft's usual number of them takes too long.
        has_others: whether a person also says a text that the code does not know; not where it raises then.
        no_waivers: where first runs executed what the code waives as unreachable, `file:line`; empty: nowhere.
        isolates: whether each test has a process of its own: one leaves a state of the code to the next.
        dialogs: what a person says one after the other, each as the commands of a test.
        may_end: how runs may end: all that is known where none was made, and as the first runs ended otherwise.
    """

    findings: Findings
    robot: str
    person: str
    folder: Path
    takes_time: bool = False
    dropped: tuple[str, ...] = ()
    has_dropped_all: bool = False
    untriggered: Mapping[str, str] = field(default_factory=dict)
    ros: RosStart | None = None
    observed: Observed | None = None
    sizes: Mapping[str, int] = field(default_factory=dict)
    has_others: bool = True
    no_waivers: str = ""
    isolates: bool = False
    may_end: tuple[str, ...] = ENDS
    dialogs: tuple[tuple[str, ...], ...] = ()

    @property
    def entry(self) -> Entry | None:
        """What is called."""
        return self.findings.entry

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
    def things(self) -> tuple[Thing, ...]:
        """What a person can say."""
        return tuple(_thing(message, self.has_others) for message in self.findings.heard)

    @cached_property
    def sensors(self) -> tuple[Sensor, ...]:
        """What the code reads at its devices."""
        return tuple(sensors_of(self.devices))

    @cached_property
    def motions(self) -> dict[str, tuple[Motion, ...]]:
        """Port -> what moves of its stand-in."""
        return motions_of(self.devices)

    @property
    def called(self) -> dict[str, tuple[str, ...]]:
        """Port -> the methods by which the code tells the device something, where there are some."""
        sensors = {(sensor.port, sensor.operation.name) for sensor in self.sensors}
        sensors |= {(port, value.operation.name) for port, motions in self.motions.items() for motion in motions
                    for value in motion.readings}  # fmt: skip
        calls = {
            port.name: tuple(
                operation.name.strip("_")
                for operation in port.operations
                if operation.kind == "method" and (port.name, operation.name) not in sensors
                if not operation.name.startswith("__") or operation.name == "__call__"
            )
            for port in self.devices
        }
        return {port: tuple(dict.fromkeys(names)) for port, names in calls.items() if names}

    @cached_property
    def told(self) -> tuple[Told, ...]:
        """What the code tells its devices."""
        return told_of(self.devices, self.sensors)

    @cached_property
    def signals(self) -> tuple[Signal, ...]:
        """One for each field that the robot says."""
        return tuple(
            Signal(f"said_{message.topic}_{part.name}", part.kind, message.topic, part.name, part.place)
            for message in self.findings.said
            for part in message.fields
            if part.kind
        )

    @property
    def messages(self) -> tuple[Message, ...]:
        """All messages of the bus, by their names."""
        return tuple(sorted(self.findings.messages, key=lambda message: message.name))

    @cached_property
    def answers(self) -> tuple[Message, ...]:
        """What the robot says to people: all but its states, unless it says nothing else."""
        states = self.findings.state.partition(".")[0]
        others = tuple(message for message in self.findings.said if message.topic != states)
        return others or self.findings.said

    @property
    def tells_presence(self) -> bool:
        """Whether signals tell that the person is there, for a requirement where there is no other."""
        return self.has_dropped_all or not self.findings.said or not self.things

    @property
    def is_alone(self) -> bool:
        """Whether nothing is known that a person could do with the robot, but to stay with it."""
        return not self.things and not self.sensors

    @property
    def states(self) -> tuple[str, ...]:
        """The states that the code tells."""
        machine = next((machine for machine in self.findings.machines if machine.told), None)
        return tuple(state.name for state in machine.states) if machine is not None else ()

    @property
    def transitions(self) -> tuple[tuple[str, str, Place], ...]:
        """From state to state, without those that lead nowhere else."""
        machine = next((machine for machine in self.findings.machines if machine.told), None)
        moves = machine.transitions if machine is not None else ()
        return tuple((move.source, move.target, move.place) for move in moves if move.source != move.target)

    @property
    def late_s(self) -> tuple[float, Place | None]:
        """The longest time-out of the code, with its place; None for a chosen one."""
        waits = [(wait.seconds, wait.place) for wait in self.findings.waits if wait.bounded and wait.seconds]
        waits += [(c.value, c.place) for c in self.findings.constants if c.unit == "s"]
        fit = [(seconds, place) for seconds, place in waits if seconds is not None and seconds <= MOST_LATE_S]
        longest = max(fit, key=lambda wait: wait[0], default=None)
        return (longest[0], longest[1]) if longest is not None and longest[0] >= 1.0 else (self.patience_s, None)

    @property
    def patience_s(self) -> float:
        """How long a person waits at least for an answer, and who is too late."""
        return LATE_S if self.ros is None else LATE_FOR_NODES_S

    @property
    def is_step(self) -> bool:
        """Whether something calls the robot again and again."""
        return self.entry is not None and self.entry.is_step

    @property
    def is_async(self) -> bool:
        """Whether the robot is a coroutine."""
        return self.entry is not None and self.entry.is_async

    @property
    def plain(self) -> tuple[Message, ...]:
        """Messages for which the code has no class: the draft's ports have one."""
        return tuple(message for message in self.findings.messages if not message.module)

    @property
    def topics(self) -> tuple[Message, ...]:
        """Those of them whose topic is a text."""
        others = {port.name.strip("_") for port in self.ports} | {channel.name for channel in self.findings.channels}
        return tuple(m for m in self.plain if m.form not in ("state", "failure", "call") and m.channel not in others)

    @property
    def missing(self) -> tuple[str, ...]:
        """Modules that get a stand-in."""
        return tuple(
            problem.text.split("`")[1]
            for problem in self.findings.problems
            if problem.kind in ("missing module", "hardware") and "`" in problem.text
        )


def robot_name(findings: Findings) -> str:
    """A name for the project: that of the entry's module, or of the package."""
    return name_like(findings.package.rstrip("/").rpartition("/")[2].removesuffix(".py").rpartition(".")[2])


def is_open(part: MessageField) -> bool:
    """Whether a field may also have a text that the code does not know."""
    return part.kind == "str" and bool(part.values) and not part.by_type


def _levels(part: MessageField) -> list[tuple[str, str, str, Place]]:
    """Ranges of a number around those that the code compares it with; what is usual first."""
    low, high = min(part.compared), max(part.compared)
    width = max(abs(low), abs(high), 3.0 if part.type == "int" else 0.0) or 1.0
    ranges = [("mid", low, high)] if low < high else []
    ranges += [("high", high + width / 4, high + width), ("low", low - width, low - width / 4)]
    return [(f"{level}_{word(part.name)}", part.name, f'Range({a:g}, {b:g}, "{part.unit}")', part.place)
            for level, a, b in ranges]  # fmt: skip


def _thing(message: Message, has_others: bool) -> Thing:
    choices: list[list[tuple[str, str, str, Place]]] = []
    numbers = []
    for part in message.leaves:
        if part.empty:  # of many, one
            options = [("with_" + word(part.name), part.name, "", part.place)]
            choices.append([*options, ("no_" + word(part.name), part.name, part.empty, part.place)])
        elif part.kind == "str":
            owner = part.name.rpartition(".")[0]
            texts = [(word(f"{owner}_{v.text}" if owner else v.text), part.name, _source(part, v.text), v.place)
                     for v in part.values]  # fmt: skip
            if has_others and is_open(part):
                texts.append(
                    (word(f"{owner}_other" if owner else "other"), part.name, f'"{OTHER}"', part.values[0].place)
                )
            choices.append(texts or [("", part.name, '"text"', part.place)])
        elif part.kind == "bool":
            options = [("with_" + word(part.name), part.name, "True", part.place)]
            choices.append([*options, ("no_" + word(part.name), part.name, "False", part.place)])
        elif part.kind == "float":
            numbers.append(part)
            choices += [_levels(part)] if part.compared else []
    floats = {part.name for part in numbers}
    kinds: list[Kind] = []
    for every in _combined(choices):
        combination = _without_parts_of_nothing(every, {part.name for part in message.leaves if part.empty})
        name = "_".join(choice[0] for choice in combination if choice[0])
        values = tuple((choice[1], choice[2]) for choice in combination if choice[1] not in floats)
        ranges = tuple((choice[1], choice[2]) for choice in combination if choice[1] in floats)
        place = combination[0][3] if combination else message.place
        if all(kind.name != name for kind in kinds):
            usual = {choice[0] for choice in choices} if values else set(combination)
            is_known = all(source != f'"{OTHER}"' for _, source in values)
            is_usual = is_known and all(part in usual for part in combination if part[1] in floats)
            kinds.append(Kind(name, values, place, ranges, is_usual))
    return Thing(message, word(message.topic), tuple(kinds), tuple(numbers))


def _without_parts_of_nothing(
    combination: tuple[tuple[str, str, str, Place], ...], optional: set[str]
) -> tuple[tuple[str, str, str, Place], ...]:
    """The choices that are left where something within the message is not there."""
    absent = tuple(f"{path}." for _, path, source, _ in combination if path in optional and source)
    return tuple(choice for choice in combination if not choice[1].startswith(absent))


def _combined(choices: list[list[tuple[str, str, str, Place]]]) -> list[tuple[tuple[str, str, str, Place], ...]]:
    """All combinations, or where these are too many, some in which each choice is."""
    combinations = list(product(*choices))
    if len(combinations) <= MOST_KINDS:
        return combinations
    first = [choice[0] for choice in choices]
    rows = [tuple(first)]
    for number, choice in enumerate(choices):  # each option with what is usual of the others
        rows += [(*first[:number], option, *first[number + 1 :]) for option in choice[1:]]
    longest = max(range(len(choices)), key=lambda number: len(choices[number]))
    options = choices[longest]
    for number, choice in enumerate(choices):  # and what is unusual with another option of the longest one
        if number != longest:
            for turn, option in enumerate(choice[1:], 1):
                row = [*first[:number], option, *first[number + 1 :]]
                row[longest] = options[turn % len(options)]
                rows.append(tuple(row))
    return rows[: max(MOST_KINDS, len(options))]


def _source(part: MessageField, text: str) -> str:
    """How a value is written: as a text, or as the member of an enumeration."""
    if (
        part.by_type
        and not part.type.startswith(("Literal", "typing.Literal", "t.Literal"))
        and part.type.isidentifier()
    ):
        return f"_member({part.type}, {text!r})"
    return repr(text).replace("'", '"') if '"' not in text and "'" not in text else repr(text)
