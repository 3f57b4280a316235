"""Messages without a class: what goes through queues as texts, numbers, dicts and tuples."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from pytest_hricdv.extra.draft.found.findings import (
    Certainty,
    Channel,
    Direction,
    Entry,
    FoundValue,
    Message,
    MessageField,
    Place,
    Question,
)
from pytest_hricdv.extra.draft.messages.classes import MessageClasses
from pytest_hricdv.extra.draft.messages.connections import LINES, RECEIVES, SENDS, constructor, sent
from pytest_hricdv.extra.draft.messages.plain_reader import PlainReader
from pytest_hricdv.extra.draft.messages.plain_value import PlainValue, fields_of
from pytest_hricdv.extra.draft.messages.speech import QUEUES, SUBSCRIBES
from pytest_hricdv.extra.draft.reading.naming import camel, snake, unit_of, word
from pytest_hricdv.extra.draft.reading.sources import Module, Scope, Sources, dotted_name, imported_name
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow, parameter_names

TAKES = ("get", "get_nowait")
PUTS = ("put", "put_nowait")
READS = ("readline", "readuntil", "read", "readexactly", "read_until")
WRITES = ("write", "writelines")
ROLES = {"queue": "port", "reader": "stream", "writer": "stream"}
"""Role of a parameter of the entry -> kind of its holder."""

TYPES = {"str": "str", "float": "float", "bool": "bool"}
DEFAULTS = {"str": '""', "float": "0.0", "bool": "False"}


@dataclass(frozen=True)
class Holder:
    """A queue, by what holds it.

    `kind` is "port" (a parameter of the entry), "stream" (likewise, of lines), "terminal", "topic", "attribute" (of
    the entry's class), "variable" (of a module), "made" (a connection that a call makes), "local" (of a function) or
    "other" (an attribute of another class); `owner` is the class or module, of a connection "module:name:attribute".
    """

    kind: str
    owner: str
    name: str


@dataclass(frozen=True)
class End:
    """A place where the code takes from a queue, or puts into it; `variable` is its name as the module has it."""

    holder: Holder
    is_taken: bool
    node: ast.AST
    put: ast.expr | None
    module: Module
    scope: Scope | None
    variable: str

    @property
    def place(self) -> Place:
        """Where it is."""
        return self.module.place(self.node)


@dataclass(frozen=True)
class Plain:
    """All that is said and heard without a class."""

    messages: tuple[Message, ...]
    channels: tuple[Channel, ...]
    questions: tuple[Question, ...]

    def has(self, channel: str) -> bool:
        """Whether messages come or go by this channel."""
        return any(message.channel == channel for message in self.messages)

    def without(self, channel: str) -> Plain:
        """The same without a channel: what is printed counts where nothing else is said."""
        messages = tuple(message for message in self.messages if message.channel != channel)
        return Plain(messages, tuple(other for other in self.channels if other.name != channel), self.questions)

    def only(self, channels: Iterable[str]) -> Plain:
        """The same without queues by which no message comes or goes: they stay the code's own."""
        used = set(channels)
        return Plain(self.messages, tuple(own for own in self.channels if own.name in used), self.questions)


class PlainFinder:
    """Finds messages without a class."""

    def __init__(self, sources: Sources, flow: ValueFlow, classes: MessageClasses, entry: Entry | None) -> None:
        self._sources, self._flow, self._classes, self._entry = sources, flow, classes, entry
        self._reader = PlainReader(sources, flow)
        ports = (*entry.ports, *entry.method_ports) if entry is not None else ()
        self._ports = {(port.place, port.name): port for port in ports}

    def found(self) -> Plain:
        """Messages, the queues that are no ports, and what could not be read."""
        messages: list[Message] = []
        channels: list[Channel] = []
        questions: list[Question] = []
        for holder, ends in self._by_holder():
            direction, own = self._side(ends)
            if not direction:
                continue
            if holder.kind in ("local", "other"):
                questions.append(_unreachable(holder, own[0].place, direction))
                continue
            value = self._value(direction, ends)
            if not self._has_class(own, value):
                is_line = any(getattr(getattr(end.node, "func", None), "attr", "") in LINES for end in own)
                names = {message.name for message in messages}
                made = list(messages_of(holder, direction, value, [end.place for end in own], is_line))
                messages += [_renamed(message, direction) if message.name in names else message for message in made]
                if not value.is_known:
                    questions.append(_unknown(holder, direction, own[0].place))
            if holder.kind not in ("port", "stream"):
                channels.append(replace(_channel(holder, direction, own), **self._connection(holder, own, value)))
        plain = Plain(tuple(messages), tuple(channels), tuple(questions))
        is_said = any(message.direction == "said" and message.channel != "print" for message in messages)
        return plain.without("print") if is_said else plain

    def _connection(self, holder: Holder, ends: Sequence[End], value: PlainValue) -> dict[str, Any]:
        """What is known of a connection: how it is made, and whether texts come and go as texts."""
        names = {getattr(getattr(end.node, "func", None), "attr", "") for end in ends}
        if holder.kind != "made" and not names & {*RECEIVES, *SENDS}:
            return {}
        made = holder.owner if holder.kind == "made" else ""
        return {"made": made, "is_connection": True, "is_text": not (value.is_bytes or value.kind == "number")}

    # --- ends of queues

    def _by_holder(self) -> Iterator[tuple[Holder, list[End]]]:
        """The ends of each queue; of a stream and a terminal, what is read and what is written apart."""
        by_holder: dict[tuple[Holder, bool], list[End]] = {}
        for end in (*self._ends(), *self._terminal()):
            func = getattr(getattr(end.node, "func", None), "attr", "")
            is_apart = end.holder.kind in ("stream", "terminal", "made") or func in (*RECEIVES, *SENDS)
            by_holder.setdefault((end.holder, is_apart and end.is_taken), []).append(end)
        for (holder, _), ends in by_holder.items():
            yield holder, ends

    def _terminal(self) -> Iterator[End]:
        """What is read with `input()` and said with `print()`."""
        if self._entry is not None and self._entry.is_async:
            return
        for module, scope, node in self._flow.nodes:
            name = node.func.id if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) else ""
            if isinstance(node, ast.Call) and name in ("input", "print") and self._is_program(scope):
                put = node.args[0] if len(node.args) == 1 else ast.copy_location(ast.JoinedStr([]), node)
                yield End(Holder("terminal", "", name), name == "input", node, put, module, scope, name)
            elif (isinstance(node, ast.For) and dotted_name(node.iter) == "sys.stdin" and self._is_program(scope)) or (
                isinstance(node, ast.Call)
                and dotted_name(node.func) == "sys.stdin.readline"
                and self._is_program(scope)
            ):
                yield End(Holder("terminal", "", "stdin"), True, node, None, module, scope, "stdin")

    def _is_program(self, scope: Scope | None) -> bool:
        """Whether a place is of the program: in a function that may be called, or at the top of one without any."""
        return (scope is None) == (self._entry is None)

    def _ends(self) -> Iterator[End]:
        for module, scope, node in self._flow.nodes:
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in (
                *TAKES, *PUTS, *READS, *WRITES, *RECEIVES, *SENDS
            ):  # fmt: skip
                is_taken = node.func.attr in TAKES + READS + RECEIVES
                put = None if is_taken else sent(node, node.func.attr)
                if node.func.attr in TAKES and node.args and not isinstance(getattr(node.args[0], "value", None), bool):
                    continue  # `get("key")` of a dict
                yield from self._end(node.func.value, is_taken, node, put, module, scope)
            elif isinstance(node, ast.AsyncFor | ast.For):
                taken = node.iter
                if isinstance(taken, ast.Call) and getattr(taken.func, "id", "") == "iter" and len(taken.args) == 2:
                    taken = taken.args[0].value if isinstance(taken.args[0], ast.Attribute) else taken
                yield from self._end(taken, True, node, None, module, scope)

    def _end(
        self, queue: ast.expr, is_taken: bool, node: ast.AST, put: ast.expr | None, module: Module, scope: Scope | None
    ) -> Iterator[End]:
        called = node.func.attr if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) else ""
        is_connection = called in {*RECEIVES, *SENDS} - {*TAKES, *PUTS, *READS, *WRITES}
        holder = self._holder(queue, module, scope, is_connection)
        if holder is not None:
            yield End(holder, is_taken, node, put, module, scope, queue.id if isinstance(queue, ast.Name) else "")

    def _holder(
        self, queue: ast.expr, module: Module, scope: Scope | None, is_connection: bool = False
    ) -> Holder | None:
        """Which queue it is; None where it is none."""
        attribute, local = None, None
        for node, where, at in self._flow.expressions(queue, module, scope):
            if isinstance(node, ast.Name):
                port = self._port(node.id, at)
                if port is not None:
                    return port
                variable = self._variable(node.id, where, at)
                if variable is not None:
                    return variable
                local = local or node.id
            elif isinstance(node, ast.Attribute):
                owner = self._flow.owner_of(node.value, where, at)
                attribute = attribute or (owner.name if owner is not None else "", node.attr)
            elif (made := constructor(node, where)) is not None:
                named = attribute[1] if attribute is not None else local or "connection"
                return Holder("made", ":".join((where.name, *made)), named)
            elif attribute is not None and is_connection and isinstance(node, ast.Call):
                if getattr(node.func, "attr", "").strip("_") in SUBSCRIBES:
                    return None  # an inbox of a bus
                if self._entry is not None and attribute[0] == self._entry.name:
                    return Holder("attribute", *attribute)  # made by something else: `context.socket()`
            elif isinstance(node, ast.Call) and imported_name(where, node.func) in QUEUES:
                if attribute is not None:
                    is_of_entry = self._entry is not None and attribute[0] == self._entry.name
                    return Holder("attribute" if is_of_entry else "other", *attribute)
                return Holder("local", "", local) if local is not None else None
        return None

    def _port(self, name: str, scope: Scope | None) -> Holder | None:
        if scope is None or isinstance(scope.node, ast.ClassDef) or name not in parameter_names(scope.node):
            return None
        arguments = scope.node.args
        part = next(p for p in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs) if p.arg == name)
        port = self._ports.get((scope.module.place(part), name))
        is_one = port is not None and port.role in ROLES
        return Holder(ROLES[port.role], "", port.name) if port is not None and is_one else None

    def _variable(self, name: str, module: Module, scope: Scope | None) -> Holder | None:
        if scope is not None and not isinstance(scope.node, ast.ClassDef) and name in parameter_names(scope.node):
            return None
        defined = self._sources.definition(module, name)
        if defined is None or not isinstance(defined[1], ast.Assign | ast.AnnAssign):
            return None
        value = defined[1].value
        is_connection = constructor(value, defined[0]) is not None if value is not None else False
        if isinstance(value, ast.Call) and (imported_name(defined[0], value.func) in QUEUES or is_connection):
            target = defined[1].targets[0] if isinstance(defined[1], ast.Assign) else defined[1].target
            return Holder("variable", defined[0].name, target.id if isinstance(target, ast.Name) else name)
        return None

    def _side(self, ends: Sequence[End]) -> tuple[Direction | None, list[End]]:
        """Whether the code hears a queue or says into it, with the ends of its own; None: it does both, inside."""
        takes = [end for end in ends if end.is_taken and not self._is_from_outside(end)]
        puts = [end for end in ends if not end.is_taken and not self._is_from_outside(end)]
        if takes and not puts:
            return "heard", takes
        return ("said", puts) if puts and not takes else (None, [])

    def _is_from_outside(self, end: End) -> bool:
        """At the top of a program, or in a method that hands something in or out and that nobody of the code calls."""
        if end.scope is None:
            return end.holder.kind != "terminal"
        function = end.scope.node
        assert not isinstance(function, ast.ClassDef)
        if any(call.scope is not None for call in self._flow.calls.get(function.name, ())):
            return False
        is_entry = self._entry is not None and function.name in (self._entry.name, self._entry.method)
        if end.is_taken:
            parent = self._reader.parent(end.node)
            return not is_entry and isinstance(parent, ast.Return)
        names = {node.id for node in ast.walk(end.put) if isinstance(node, ast.Name)} if end.put is not None else set()
        return not is_entry and bool(names & set(parameter_names(function)) - {"self"})

    # --- what goes through

    def _value(self, direction: Direction, ends: Sequence[End]) -> PlainValue:
        value = PlainValue(ends[0].place)
        for end in ends:
            if end.is_taken and direction == "heard":
                self._taken(end, value)
            elif end.put is not None:
                self._reader.write(end.put, end.module, end.scope, value)
        return value.finish()

    def _taken(self, end: End, value: PlainValue) -> None:
        if isinstance(end.node, ast.Call) and getattr(end.node.func, "attr", "") == "recvfrom":
            pair = PlainValue(end.place)
            self._reader.read(end.node, end.module, end.scope, pair)
            first = pair.items.get(0, value)
            value.texts |= first.texts
            value.keys |= first.keys
            value.is_text, value.is_json, value.is_bytes = first.is_text, first.is_json, first.is_bytes
            return
        if isinstance(end.node, ast.For | ast.AsyncFor):
            if isinstance(end.node.target, ast.Name) and end.scope is not None:
                self._reader.read_name(end.node.target.id, end.scope, value)
            elif isinstance(end.node.target, ast.Name):
                self._reader.read_global(end.node.target.id, end.module, value)
        else:
            self._reader.read(end.node, end.module, end.scope, value)

    def _has_class(self, ends: Sequence[End], value: PlainValue) -> bool:
        """Whether a class of the code goes through."""
        for end in ends:
            if end.put is not None and any(self._classes.classes_in(end.put, end.module, end.scope)):
                return True
        return value.is_object


def messages_of(
    holder: Holder, direction: Direction, value: PlainValue, places: Sequence[Place], is_line: bool = False
) -> Iterator[Message]:
    """One for each form that the value has."""
    uses = tuple(dict.fromkeys(places))
    if holder.kind == "stream" or is_line:
        lines = {text.strip(): place for text, place in value.texts.items() if text.strip()}
        yield _message(holder, direction, PlainValue(value.place, lines, is_text=True), uses, "line")
        return
    if value.keys:
        yield _message(holder, direction, value, uses, "json" if value.is_json else "dict")
    if value.items and not value.keys:
        yield _message(holder, direction, value, uses, "tuple")
    alone = PlainValue(value.place, texts=value.texts, is_text=value.is_text, is_number=value.is_number,
                       is_bool=value.is_bool)  # fmt: skip
    is_all = not (value.keys or value.items)
    if is_all or (value.texts and not value.is_json):
        yield _message(holder, direction, alone, uses, {"float": "number"}.get(alone.kind, "text"))


def _message(holder: Holder, direction: Direction, value: PlainValue, uses: tuple[Place, ...], form: str) -> Message:
    name = camel(holder.name.strip("_")) + form.capitalize()
    paths: list[tuple[str | int, ...]] = []
    fields: dict[str, MessageField] = {}
    for path, content in fields_of(value):
        part = _field(_name(path, value, form), content)
        if part.name not in fields:
            fields[part.name] = part
            paths.append(path)
    certainty: Certainty = "certain" if value.is_known else "likely"
    return Message(name, snake(name), "", direction, tuple(fields.values()), uses[0], uses, form,
                   holder.name.strip("_"), certainty=certainty, paths=tuple(paths))  # fmt: skip


def _name(path: tuple[str | int, ...], value: PlainValue, form: str) -> str:
    if not path:
        return "number" if form == "number" else "text"
    parts, holder = [], value
    for step in path:
        if isinstance(step, int):
            named = holder.names.get(step, "").strip("_")
            parts.append(named if named and named not in parts else "kind" if step == 0 else f"item_{step}")
            holder = holder.items[step]
        else:
            parts.append(word(step))
            holder = holder.keys[step]
    return word("_".join(parts))


def _field(name: str, value: PlainValue) -> MessageField:
    kind = value.kind
    values = tuple(FoundValue(text, place) for text, place in value.texts.items()) if kind == "str" else ()
    unit = unit_of(name) if kind == "float" else ""
    numbers = tuple(value.numbers) if kind == "float" else ()
    return MessageField(name, TYPES[kind], kind, value.place, values, unit, DEFAULTS[kind], compared=numbers)


def _channel(holder: Holder, direction: Direction, ends: Sequence[End]) -> Channel:
    name = holder.name.strip("_")
    if holder.kind == "made":
        return Channel(name, direction, ends[0].place)
    if holder.kind == "attribute":
        return Channel(name, direction, ends[0].place, attribute=holder.name)
    variables = {(end.module.name, end.variable) for end in ends if end.variable}
    if holder.owner:
        variables.add((holder.owner, holder.name))
    return Channel(name, direction, ends[0].place, variables=tuple(sorted(variables)))


def _renamed(message: Message, direction: Direction) -> Message:
    """What goes the other way by the same connection has another name."""
    name = message.name + ("Sent" if direction == "said" else "Received")
    return replace(message, name=name, topic=snake(name))


def _unreachable(holder: Holder, place: Place, direction: Direction) -> Question:
    where = "is made within a function" if holder.kind == "local" else f"is made within `{holder.owner or '?'}`"
    does = "takes from" if direction == "heard" else "puts into"
    text = (
        f"The code {does} `{holder.name}`, which {where}: the draft cannot reach it. Hand it over as a parameter of "
        "what runs the robot, and draft again"
    )
    return Question(text, "messages", place)


def _unknown(holder: Holder, direction: Direction, place: Place) -> Question:
    if direction == "heard":
        return Question(f"What comes through `{holder.name}`? Nothing is done with it that says so", "messages", place)
    return Question(f"What does the code put into `{holder.name}`? The draft takes it for a text", "messages", place)
