"""Messages whose topic is a text: `bus.publish("state", payload)`, `bus.subscribe("order", callback)`."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field

from pytest_hricdv.extra.draft.found.findings import Direction, Entry, Message, Place, Problem, Question
from pytest_hricdv.extra.draft.messages.classes import MessageClasses
from pytest_hricdv.extra.draft.messages.connections import MODULES
from pytest_hricdv.extra.draft.messages.plain import Holder, messages_of
from pytest_hricdv.extra.draft.messages.plain_reader import PlainReader
from pytest_hricdv.extra.draft.messages.plain_value import PlainValue
from pytest_hricdv.extra.draft.messages.speech import EVENTS, OPTIONS, PAYLOADS, QUEUE_ONLY, SAYS, SENDERS, SUBSCRIBES
from pytest_hricdv.extra.draft.reading.sources import Module, Scope, Sources, dotted_name, imported_name
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow, parameter_names


@dataclass
class _Topic:
    value: PlainValue
    places: list[Place] = field(default_factory=list)
    has_class: bool = False


class TopicFinder:
    """Finds topics that are texts, on a bus that the robot is handed."""

    def __init__(self, sources: Sources, flow: ValueFlow, classes: MessageClasses, entry: Entry | None) -> None:
        self._sources, self._flow, self._classes = sources, flow, classes
        self._reader = PlainReader(sources, flow)
        ports = (*entry.ports, *entry.method_ports) if entry is not None else ()
        self._buses = {(port.place, port.name) for port in ports if port.role == "bus"}
        self._topics: dict[tuple[str, Direction], _Topic] = {}
        self._questions: list[Question] = []
        self.is_taken_from = False
        """Whether the code takes from what it gets for subscribing, as from a queue: known after `found`."""
        self._unseen: dict[tuple[str, str], dict[Direction, dict[str, Place]]] = {}

    def found(self) -> tuple[tuple[Message, ...], tuple[Question, ...]]:
        """The messages, and what could not be read."""
        for module, scope, node in self._flow.nodes:
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.args:
                self._called(node, node.func, module, scope)
            if isinstance(node, ast.Attribute) and node.attr in QUEUE_ONLY:
                self.is_taken_from |= self._is_subscribed(node.value, module, scope)
        messages: list[Message] = []
        for (topic, direction), found in self._topics.items():
            if not found.has_class:
                messages += messages_of(Holder("topic", "", topic), direction, found.value.finish(), found.places)
        return tuple(messages), tuple(dict.fromkeys(self._questions))

    def _called(self, node: ast.Call, func: ast.Attribute, module: Module, scope: Scope | None) -> None:
        verb = func.attr.strip("_")
        direction: Direction = "said" if verb in SAYS else "heard"
        if direction == "heard" and verb not in SUBSCRIBES:
            return
        texts = [text for text in self._flow.constants(node.args[0], module, scope) if isinstance(text, str)]
        if not texts or isinstance(node.args[0], ast.JoinedStr):
            return
        place = module.place(node)
        if not self._is_bus(func.value, module, scope):
            library = self._library(func.value, module, scope)
            if library:
                by_side = self._unseen.setdefault((dotted_name(func.value), library), {})
                by_side.setdefault(direction, {}).update(dict.fromkeys(texts, place))
            elif verb in ("publish", "subscribe") and scope is not None:
                name = dotted_name(func.value) or "something"
                text = (
                    f"`{name}` carries the topic {texts[0]!r}, and is no parameter of what runs the robot: hand it over"
                )
                self._questions.append(Question(f"{text}, and draft again", "messages", place))
            return
        arguments = [*node.args[1:], *(keyword.value for keyword in node.keywords)]
        for text in texts:
            topic = self._topics.setdefault((text, direction), _Topic(PlainValue(place)))
            topic.places.append(place)
            if direction == "said":
                self._said(topic, node, module, scope)
            else:
                self._heard(topic, text, arguments, place)

    def _is_subscribed(self, queue: ast.expr, module: Module, scope: Scope | None) -> bool:
        return any(
            isinstance(node, ast.Call)
            and isinstance(node.func, ast.Attribute)
            and node.func.attr.strip("_") in SUBSCRIBES
            and self._is_bus(node.func.value, where, at)
            for node, where, at in self._flow.expressions(queue, module, scope)
        )

    def unseen(self) -> Iterator[Problem]:
        """Topics that go by something that a library makes, which no test can see: after `found`."""
        for (name, library), by_side in self._unseen.items():
            sides = {"said": "says", "heard": "hears"}
            listed = " and ".join(
                f"{sides[direction]} {', '.join(map(repr, topics))}" for direction, topics in sorted(by_side.items())
            )
            place = next(iter(next(iter(by_side.values())).values()))
            why = f"`{name}` of `{library}` {listed}: the draft sees none of it, as `{name}` is no parameter"
            yield Problem("unseen", f"{why} of what runs the robot. Hand it over, and draft again", place)

    def _library(self, receiver: ast.expr, module: Module, scope: Scope | None) -> str:
        """The library that something comes from, as `sio = socketio.AsyncClient()`; empty where it is of the code."""
        for node, where in self._makers(receiver, module, scope):
            root = imported_name(where, node.func).partition(".")[0]
            is_imported = root in {name.partition(".")[0] for name in where.imports.values()}
            if is_imported and root not in (*MODULES, *sys.stdlib_module_names) and not self._is_own(root):
                return root
        return ""

    def _makers(self, receiver: ast.expr, module: Module, scope: Scope | None) -> Iterator[tuple[ast.Call, Module]]:
        """The calls that something may come from, also where it is a variable of a module."""
        for node, where, _ in self._flow.expressions(receiver, module, scope):
            if isinstance(node, ast.Call):
                yield node, where
        defined = self._sources.definition(module, dotted_name(receiver))
        if defined is not None and isinstance(defined[1], ast.Assign | ast.AnnAssign):
            value = defined[1].value
            if isinstance(value, ast.Call):
                yield value, defined[0]

    def _is_own(self, root: str) -> bool:
        return any(module.name.partition(".")[0] == root for module in self._sources.modules)

    def _is_bus(self, receiver: ast.expr, module: Module, scope: Scope | None) -> bool:
        for node, _, at in self._flow.expressions(receiver, module, scope):
            if isinstance(node, ast.Name) and at is not None and not isinstance(at.node, ast.ClassDef):
                for part in (*at.node.args.posonlyargs, *at.node.args.args, *at.node.args.kwonlyargs):
                    if part.arg == node.id and (at.module.place(part), node.id) in self._buses:
                        return True
        return False

    def _said(self, topic: _Topic, node: ast.Call, module: Module, scope: Scope | None) -> None:
        """What goes with a topic: an argument, or a field for each of other keywords."""
        contents = [*node.args[1:], *(keyword.value for keyword in node.keywords if keyword.arg in PAYLOADS)]
        if len(node.args) > 2 and getattr(node.func, "attr", "").strip("_") in EVENTS:
            whole = ast.copy_location(ast.Tuple(node.args[1:], ast.Load()), node)
            self._reader.write(whole, module, scope, topic.value)
            return
        if contents:
            topic.has_class |= any(self._classes.classes_in(contents[0], module, scope))
            self._reader.write(contents[0], module, scope, topic.value)
            return
        topic.value.is_text |= not node.keywords
        for keyword in node.keywords:
            place = module.place(keyword.value)
            if keyword.arg is None:  # `**fields`
                self._reader.write(keyword.value, module, scope, topic.value)
            elif keyword.arg not in OPTIONS:
                self._reader.write(keyword.value, module, scope, topic.value.key(keyword.arg, place))

    def _heard(self, topic: _Topic, text: str, arguments: list[ast.expr], place: Place) -> None:
        callbacks = [scope for argument in arguments for scope in self._functions(argument)]
        for callback in callbacks:
            self._called_back(callback, topic.value)
        if topic.value.is_object and not topic.value.is_known:
            question = f"What comes with the topic {text!r}? Attributes of it are read, and its class is not known"
            self._questions.append(Question(question, "messages", place))
        elif not callbacks:
            question = f"What is done with the topic {text!r}? No function of the code is called with it"
            self._questions.append(Question(question, "messages", place))

    def _called_back(self, callback: Scope, value: PlainValue) -> None:
        """What a callback does with what comes: its last parameter, or several of which each is a field."""
        function = callback.node
        assert not isinstance(function, ast.ClassDef)
        names = [name for name in parameter_names(function) if name != "self"]
        named = [name for number, name in enumerate(names) if number or name.strip("_") not in SENDERS]
        if function.args.kwarg is not None or (len(named) > 1 and len(named) == len(names)):
            for name in named:
                self._reader.read_name(name, callback, value.key(name, callback.place))
            if function.args.kwarg is not None:
                self._reader.read_name(function.args.kwarg.arg, callback, value)
        elif names:
            self._reader.read_name(names[-1], callback, value)
            if len(names) > 1 and names[0] == "name":
                text = f"Is `name` of `{function.name}` the event, as the draft has it, or does it come with it?"
                self._questions.append(Question(text, "messages", callback.place))

    def _functions(self, argument: ast.expr) -> Iterator[Scope]:
        name = dotted_name(argument).rpartition(".")[2]
        yield from self._flow.methods.get(name, ()) if name else ()
