"""The code under test as a draft sees it: messages, state machines, ports, entry, as plain data with source locations.

A `Question` asks what the code does not tell. A `Problem` keeps the code from running unchanged.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from pytest_hricdv.extra.draft.ros_model import CodeLine as CodeLine
from pytest_hricdv.extra.draft.ros_model import RosNodes

Direction = Literal["published", "received", "both"]
"""The direction of a message, as seen from the code."""

Imports = tuple[tuple[str, str], ...]
"""Names that a piece of source text needs, each as (module, name)."""

OWN_MODULE = "drafted_messages"
"""The module of a draft for messages without a class in the code."""

SCRIPT = "__main__"
"""The name of an entry that is a program (`pytest_hricdv.draft.Script`)."""


@dataclass(frozen=True)
class FieldValue:
    """A text that a field can have; `is_observed` if only a recording has it, not the code."""

    text: str
    location: CodeLine
    is_observed: bool = False


@dataclass(frozen=True)
class MessageField:
    """A field of a message.

    Args:
        name: the field's name; a path (`linear.x`) within messages of ROS 2.
        type: its annotation in the source, such as `tuple[float, ...]`; empty without one.
        kind: its type in requirements: "bool", "float" (also for int), "str"; empty if they cannot compare it.
        location: the location of its declaration.
        values: the texts that it can have, in the order of the source; empty if they are not known.
        unit: the unit in its name (`level_ml`: "ml"); empty if the name has none.
        default: the source text of its default; empty without one.
        by_type: whether its type lists its values (Literal, Enum), so that a testbench need not declare them.
        compared: numbers that the code compares it with.
        is_partial: whether there are other texts than `values`, which the code computes.
        neutral: source text of a neutral value of its type; empty if the type is unknown.
        imports: names that the neutral value needs.
        observed: the least and the greatest number in a recording; empty without one.
    """

    name: str
    type: str
    kind: str
    location: CodeLine
    values: tuple[FieldValue, ...] = ()
    unit: str = ""
    default: str = ""
    by_type: bool = False
    compared: tuple[float, ...] = ()
    is_partial: bool = False
    neutral: str = ""
    imports: Imports = ()
    observed: tuple[float, ...] = ()


@dataclass(frozen=True)
class Message:
    """A message that the code publishes or receives.

    Args:
        name: the name of its class.
        topic: as requirements call it (`leg_ready`).
        module: dotted name of the class's module; in ROS 2 the type, such as `std_msgs/msg/Bool`.
        direction: published, received, or both.
        fields: the fields, in the order of the source.
        location: the location of the definition.
        uses: the places where it is published or received.
        form: "dataclass", "namedtuple", "typeddict", "model" (pydantic, attrs, msgspec), "enum"; in ROS 2 "topic",
            "service", "action"; "call" if the code receives it as a call, "item" if the draft converts it.
        channel: the queue that carries it, its name in ROS 2, or the function of a call; empty for a bus of classes.
        delivery: source text that makes the call, or that converts the item.
        delivery_imports: names that `delivery` needs.
    """

    name: str
    topic: str
    module: str
    direction: Direction
    fields: tuple[MessageField, ...]
    location: CodeLine
    uses: tuple[CodeLine, ...]
    form: str = "dataclass"
    channel: str = ""
    delivery: str = ""
    delivery_imports: Imports = ()


@dataclass(frozen=True)
class State:
    """A state of a state machine, by the text that the code uses for it."""

    name: str
    location: CodeLine


@dataclass(frozen=True)
class Transition:
    """A transition between states."""

    source: str
    target: str
    location: CodeLine


@dataclass(frozen=True)
class StateMachine:
    """A state machine.

    Args:
        name: the name of its class or table.
        kind: the library (`transitions`, `python-statemachine`), "attribute" (it declares no transitions), or
            "observed" (neither transitions nor states: there may be others).
        field: the message field with which the code publishes its state, such as `state.name`; empty without one.
        held_in: the attribute with the state, `Class.attribute`; empty if unknown.
    """

    name: str
    kind: str
    states: tuple[State, ...]
    transitions: tuple[Transition, ...]
    location: CodeLine
    field: str = ""
    held_in: str = ""


@dataclass(frozen=True)
class Operation:
    """An operation on a port: a method that the code calls, or an attribute that it reads or sets.

    Args:
        name: the name of the method or attribute; `__call__` where the port itself is called.
        is_method: False for an attribute.
        location: in the class of the port, or where the code uses it.
        returns: source text of the annotation; empty without one.
        neutral: source text of a neutral value of this type; empty if the type is unknown.
        imports: names that the neutral value needs.
        is_async: whether it is awaited.
        is_set: whether the attribute is set.
        is_registration: whether the code passes a callback to it, or sets it to one.
        result: its result, if that is a bool, a number or one of a few texts; None if unknown.
    """

    name: str
    is_method: bool
    location: CodeLine
    returns: str = ""
    neutral: str = ""
    imports: Imports = ()
    is_async: bool = False
    is_set: bool = False
    is_registration: bool = False
    result: MessageField | None = None

    @property
    def key(self) -> str:
        """Its path from the port, as stand-ins have it; the path of a method has parentheses."""
        name = self.name.removeprefix("__call__")
        return f"{name}()" if self.is_method and not name.endswith(")") else name

    def path(self, port: str) -> str:
        """Its path with the port."""
        return f"{port}{self.key}" if self.key.startswith("(") else f"{port}.{self.key}"


@dataclass(frozen=True)
class Port:
    """A parameter of the entry.

    Args:
        role: "bus", "clock", "publish" (a function that is called with each message), "queue", "connection" (a socket
            or stream that the code makes), "program" (a function that starts one; `annotation` is its dotted name),
            "parameter" (a number or string), "settings" (an object of numbers and strings), "device" (hardware, or
            anything else).
        annotation: source text; empty without one.
        default: source text; empty without one.
        direction: the direction of a queue, received or published; empty if unknown.
        neutral: source text of a neutral value of its type; empty if the type is unknown.
        imports: names that the neutral value needs.
        made_from: the class of an object that the code makes itself, as "package.module:mqtt.Client".
    """

    name: str
    role: str
    annotation: str
    default: str
    operations: tuple[Operation, ...]
    location: CodeLine
    direction: str = ""
    neutral: str = ""
    imports: Imports = ()
    made_from: str = ""


@dataclass(frozen=True)
class Entry:
    """The entry that runs the code.

    Args:
        name: the name of a function, or of a class; `SCRIPT` of a module that is a program.
        method: the method of the class, called on an instance of it; empty for a function.
        is_async: whether it is a coroutine.
        ports: parameters of the function or constructor.
        method_ports: parameters of the method.
        is_certain: whether the user named it, or it is the only candidate.
        period_s: the period with which the method is called (s); 0 if it is called once.
    """

    module: str
    name: str
    method: str
    is_async: bool
    ports: tuple[Port, ...]
    method_ports: tuple[Port, ...]
    location: CodeLine
    is_certain: bool = False
    period_s: float = 0.0

    @property
    def is_class(self) -> bool:
        """Whether it is a class, whose method is called, or whose instance gets callbacks from the bus."""
        return bool(self.method) or self.name[:1].isupper()


@dataclass(frozen=True)
class Question:
    """A question that only a person can answer; `about` is its subject in a word, such as a field or a port."""

    text: str
    about: str
    location: CodeLine | None


@dataclass(frozen=True)
class Problem:
    """A problem that keeps code from running unchanged; the rest is drafted.

    `kind` is "syntax", "missing module", "missing messages", "terminal", "recording" or "raised".
    """

    kind: str
    text: str
    location: CodeLine | None


@dataclass(frozen=True)
class CodeModel:
    """A model of the code under test.

    Args:
        package: its name, as the user gave it.
        root: absolute path of the folder from which its modules can be imported.
        modules: names of the top-level modules and packages under test.
        messages: published and received messages.
        machines: state machines; one whose state the code publishes comes first.
        time_outs: timeouts of its waits (s), with their locations.
        entry: the function or class to call; None if there is none.
        questions: what the code does not tell.
        problems: what keeps the code from running unchanged.
        ros: nodes of ROS 2, with their topics, services and actions.
        inner: objects that the code creates itself and stand-ins replace (`code.created_objects`).
        has_waivers: whether comments waive lines as unreachable.
    """

    package: str
    root: str
    modules: tuple[str, ...]
    messages: tuple[Message, ...] = ()
    machines: tuple[StateMachine, ...] = ()
    time_outs: tuple[tuple[float, CodeLine], ...] = ()
    entry: Entry | None = None
    questions: tuple[Question, ...] = ()
    problems: tuple[Problem, ...] = ()
    ros: RosNodes = field(default_factory=RosNodes)
    inner: tuple[Port, ...] = ()
    has_waivers: bool = False

    @property
    def outputs(self) -> tuple[Message, ...]:
        """Messages that the code publishes."""
        return tuple(message for message in self.messages if message.direction != "received")

    @property
    def inputs(self) -> tuple[Message, ...]:
        """Messages that the code receives."""
        return tuple(message for message in self.messages if message.direction != "published")

    @property
    def machine(self) -> StateMachine | None:
        """The machine whose state the code publishes; None if it publishes none."""
        return next((machine for machine in self.machines if machine.field), None)

    @property
    def state(self) -> str:
        """For `StateField.name`: the field in which the code publishes its state; empty if there is none."""
        return self.machine.field if self.machine is not None else ""
