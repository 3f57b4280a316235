"""What is found in code that is to be tested: plain data, each with its place, and how it was found.

A finding is *certain* where the code says it (a class that is published, a table of transitions), and *likely* where
it was concluded (a text in a docstring, a callback by its name). What could not be found is a `Question`, and what
keeps the code from being run as it is a `Problem`. Both are sentences for people.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

from pytest_hricdv.extra.draft.found.nodes import RosNodes
from pytest_hricdv.extra.draft.found.place import Place as Place
from pytest_hricdv.extra.draft.found.port import Operation as Operation
from pytest_hricdv.extra.draft.found.port import Part as Part
from pytest_hricdv.extra.draft.found.port import Port as Port

How = Literal["analysis", "run"]
"""Read in the source, or seen when the code ran."""

Certainty = Literal["certain", "likely"]

Direction = Literal["said", "heard", "both"]
"""Seen from the code: what it says, what it hears."""


@dataclass(frozen=True)
class FoundValue:
    """A text that a field can have."""

    text: str
    place: Place
    how: How = "analysis"
    certainty: Certainty = "certain"


@dataclass(frozen=True)
class MessageField:
    """A field of a message.

    Args:
        name: of the field.
        type: as the source writes it, such as `tuple[float, ...]`; empty where it does not.
        kind: what requirements see of it: "bool", "float" (also for int), "str"; empty where they cannot compare it.
        place: where it is declared.
        values: the texts that it can have, in the order of the source; empty where they are not known.
        unit: by its name (`level_ml`: "ml"); empty where the name has none.
        default: the source text of its default; empty where there is none.
        by_type: whether its type alone says which values it has (Literal, Enum): a testbench need not declare them.
        compared: numbers that the code compares it with.
        is_partial: whether the code makes it of texts, too, that are not known: `values` are some of them.
        made_of: (module, name) of the class of the code that it is an instance of, or has instances of; else empty.
        parts: the fields of this class.
        empty: source text of none of them, where there may be none: `[]`, `()`, `None`.
    """

    name: str
    type: str
    kind: str
    place: Place
    values: tuple[FoundValue, ...] = ()
    unit: str = ""
    default: str = ""
    by_type: bool = False
    compared: tuple[float, ...] = ()
    is_partial: bool = False
    made_of: tuple[str, str] = ("", "")
    parts: tuple[MessageField, ...] = ()
    empty: str = ""

    @property
    def leaves(self) -> tuple[MessageField, ...]:
        """The field and those in it, by their paths (`pickup.place`)."""
        inner = [replace(leaf, name=f"{self.name}.{leaf.name}") for part in self.parts for leaf in part.leaves]
        return (self, *inner)


@dataclass(frozen=True)
class Message:
    """A message that the code says or hears.

    Args:
        name: of its class, or the class that a testbench is to write for it where the code has none.
        topic: as requirements call it (`leg_ready`).
        module: dotted name of the module that has the class; empty where the code has no class for it. Of ROS 2, the
            type, such as `std_msgs/msg/Bool`.
        direction: said, heard, or both.
        fields: in their order.
        place: of the definition; where there is no class, of the first use.
        uses: where it is said or heard.
        form: "dataclass", "namedtuple", "typeddict", "model" (pydantic, attrs, msgspec), "enum", "call" (a method that
            somebody outside calls); without a class "text", "number", "dict", "tuple", "json" (a dict in a text),
            "state" (an attribute that is looked at); of ROS 2 "topic", "service", "action".
        channel: how it comes or goes: the name of a queue, the text of a topic; empty for a bus of classes.
        paths: where the code has no class for it, the keys and numbers that lead to each field in what it has.
    """

    name: str
    topic: str
    module: str
    direction: Direction
    fields: tuple[MessageField, ...]
    place: Place
    uses: tuple[Place, ...]
    form: str = "dataclass"
    channel: str = ""
    how: How = "analysis"
    certainty: Certainty = "certain"
    paths: tuple[tuple[str | int, ...], ...] = ()

    @property
    def leaves(self) -> tuple[MessageField, ...]:
        """Its fields, and those of the instances in them, by their paths."""
        return tuple(leaf for part in self.fields for leaf in part.leaves)


@dataclass(frozen=True)
class Channel:
    """A queue that the code makes itself, in whose place a draft puts one of the test.

    Args:
        name: of the attribute, or of the variable of a module, without underscores before it.
        direction: heard or said.
        place: of its first use.
        attribute: the name as it is written, of an attribute of what the entry makes; empty for a variable.
        variables: (module, name) of each variable that is the queue; empty for an attribute.
        is_connection: whether it is a connection, such as a serial line, and no queue.
        made: "module:name:attribute" of the call that makes a connection; empty where it does not make it by a class.
        is_text: whether texts come and go as texts, and not as bytes.
    """

    name: str
    direction: Direction
    place: Place
    attribute: str = ""
    variables: tuple[tuple[str, str], ...] = ()
    is_connection: bool = False
    made: str = ""
    is_text: bool = False


@dataclass(frozen=True)
class State:
    """A state of a state machine, by the text under which the code tells it."""

    name: str
    place: Place
    initial: bool = False
    final: bool = False
    how: How = "analysis"
    certainty: Certainty = "certain"


@dataclass(frozen=True)
class Transition:
    """From a state to the next one; `event` is what the code calls the cause, empty where it has no name."""

    source: str
    target: str
    place: Place
    event: str = ""
    how: How = "analysis"
    certainty: Certainty = "certain"


@dataclass(frozen=True)
class Machine:
    """A state machine.

    Args:
        name: of its class or table.
        kind: the library (`transitions`, `python-statemachine`, `smach`, `yasmin`, `py_trees`), or "table", "enum",
            "classes" (one for each state).
        states: in the order of the source.
        transitions: likewise.
        place: where it is defined.
        told: the field in which the code says its state, `state.name`; empty where it says none.
        held: the attribute that holds the state, `module:Class.attribute`; empty where none is known.
    """

    name: str
    kind: str
    states: tuple[State, ...]
    transitions: tuple[Transition, ...]
    place: Place
    told: str = ""
    held: str = ""


@dataclass(frozen=True)
class Wait:
    """A call that waits.

    Args:
        kind: "time", "threading", "asyncio", "rclpy", or "bus" (a message with a time-out), "clock" (a port),
            "time-out" (no call, but what is compared with the time that has passed, or added to it).
        call: as the source writes what is called, `time.sleep`.
        place: of the call.
        seconds: how long at most, where a constant says so; None else.
        bounded: whether it has a time-out.
    """

    kind: str
    call: str
    place: Place
    seconds: float | None = None
    bounded: bool = False


@dataclass(frozen=True)
class Constant:
    """A number with a unit in its name: `TOO_LONG_S = 12.0`."""

    name: str
    value: float
    unit: str
    place: Place


@dataclass(frozen=True)
class Parameter:
    """A number, text or switch that can be set from outside: of the entry, of its settings, of a ROS 2 node.

    `owner` is the class or function whose parameter it is; `default` is the source text, empty where there is none.
    """

    name: str
    owner: str
    type: str
    default: str
    unit: str
    place: Place


@dataclass(frozen=True)
class Entry:
    """What is to be called to run the code.

    Args:
        module: dotted name.
        name: of a function, or of a class.
        method: of the class, called on what its constructor makes; empty for a function.
        is_async: whether it is a coroutine.
        ports: parameters of the function or constructor.
        method_ports: parameters of the method.
        place: of its definition.
        certainty: certain where it was named, or where there is one only.
        stays: whether a class is made for those who call its methods.
        is_step: whether the method is called again and again, as it has no loop of its own.
    """

    module: str
    name: str
    method: str
    is_async: bool
    ports: tuple[Port, ...]
    method_ports: tuple[Port, ...]
    place: Place
    certainty: Certainty = "likely"
    stays: bool = False
    is_step: bool = False

    @property
    def is_made(self) -> bool:
        """Whether something is made that stays: by its method, or a class that is called or called back."""
        return (
            bool(self.method)
            or self.stays
            or (self.name[:1].isupper() and any(port.role == "bus" for port in self.ports))
        )


@dataclass(frozen=True)
class Calling:
    """A function of the code that somebody outside calls.

    Args:
        message: name of the message for which it is called.
        target: source text of what is called, of `made` or of a module.
        arguments: source text of each; `message` is the message.
        said: names of the messages that say what it returns.
        place: of its definition.
        is_async: whether it is a coroutine.
        needs: names in the arguments, as (module, name).
        request: the module whose `request` (of a web framework) it reads; empty where it reads none.
    """

    message: str
    target: str
    arguments: tuple[str, ...]
    said: tuple[str, ...]
    place: Place
    is_async: bool = False
    needs: tuple[tuple[str, str], ...] = ()
    request: str = ""


@dataclass(frozen=True)
class Question:
    """What nobody but a person can say; `about` is its subject in a word, such as a field or a port."""

    text: str
    about: str
    place: Place | None


@dataclass(frozen=True)
class Problem:
    """What keeps code from being run as it is: said, and the rest drafted.

    `kind` is "syntax", "missing module", "hardware", "side effect", "terminal", "outside", "import", "raised",
    "unrepeatable", "entry", "unseen", "late".
    """

    kind: str
    text: str
    place: Place | None


@dataclass(frozen=True)
class Findings:
    """All that was found in a package.

    Args:
        package: its name, as it was asked for.
        root: absolute path of the folder from which its modules can be imported.
        code: names of the top-level modules and packages under test.
        messages: said and heard.
        machines: state machines; the one that the code tells first.
        waits: all calls that wait.
        virtual: "time", "threading", "asyncio": for `Testbench.virtual`.
        constants: numbers with units.
        parameters: what can be set.
        entry: what to call; None where nothing was found.
        questions: what could not be found.
        problems: what was in the way.
        ros: nodes of ROS 2, with what they say and hear.
        roots: further folders from which its modules can be imported, of several packages.
        channels: queues that the code makes itself, and through which messages come and go.
        calls: functions that somebody outside calls.
        script: the module that is a program without a function; empty where none is.
        is_taken_from: whether the code takes from its subscriptions as from queues.
    """

    package: str
    root: str
    code: tuple[str, ...]
    messages: tuple[Message, ...] = ()
    machines: tuple[Machine, ...] = ()
    waits: tuple[Wait, ...] = ()
    virtual: tuple[str, ...] = ()
    constants: tuple[Constant, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    entry: Entry | None = None
    questions: tuple[Question, ...] = ()
    problems: tuple[Problem, ...] = ()
    ros: RosNodes = field(default_factory=RosNodes)
    channels: tuple[Channel, ...] = ()
    roots: tuple[str, ...] = ()
    calls: tuple[Calling, ...] = ()
    script: str = ""
    is_taken_from: bool = False

    @property
    def said(self) -> tuple[Message, ...]:
        """What the code says."""
        return tuple(message for message in self.messages if message.direction in ("said", "both"))

    @property
    def heard(self) -> tuple[Message, ...]:
        """What the code hears."""
        return tuple(message for message in self.messages if message.direction in ("heard", "both"))

    @property
    def state(self) -> str:
        """For `Testbench.state`: the field in which the code tells its state; empty where it tells none."""
        return next((machine.told for machine in self.machines if machine.told), "")
