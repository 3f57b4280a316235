"""Messages of the code: classes that it publishes or subscribes, and what goes through queues, topics and streams."""

from __future__ import annotations

import ast
from collections import defaultdict
from dataclasses import dataclass, field

from pytest_hricdv.extra.draft.found.findings import Direction, Message, Place
from pytest_hricdv.extra.draft.messages.classes import MessageClasses
from pytest_hricdv.extra.draft.messages.fields import MessageFields
from pytest_hricdv.extra.draft.messages.speech import CALLBACK, SAYS, SUBSCRIBES, TAKES
from pytest_hricdv.extra.draft.reading.classes import form_of
from pytest_hricdv.extra.draft.reading.naming import snake
from pytest_hricdv.extra.draft.reading.sources import Module, Scope, Sources, dotted_name
from pytest_hricdv.extra.draft.reading.value_flow import Call, ValueFlow, last_name, parameter_names


@dataclass
class Uses:
    """Where a class is said and heard."""

    said: list[Place] = field(default_factory=list)
    heard: list[Place] = field(default_factory=list)
    likely: list[Place] = field(default_factory=list)
    """Heard, by the name of a callback or by a test of its class."""
    channels: list[str] = field(default_factory=list)


class MessageFinder:
    """Finds the messages of the code."""

    def __init__(self, sources: Sources, flow: ValueFlow, classes: MessageClasses) -> None:
        self._sources, self._flow = sources, flow
        self._classes, self._fields = classes, MessageFields(sources, flow, classes)
        self._uses: dict[int, Uses] = defaultdict(Uses)
        self._scopes: dict[int, Scope] = {}

    def messages(self) -> tuple[Message, ...]:
        """All messages, in the order of the code."""
        inside = self._inside_queues()
        for module, scope, node in self._flow.nodes:
            if isinstance(node, ast.Call):
                self._called(Call(module, scope, node), inside)
            elif isinstance(node, ast.MatchClass):
                self._tested(module, scope, node.cls, None)
            elif isinstance(node, ast.AnnAssign | ast.arg) and node.annotation is not None:
                self._annotated(module, scope, node, inside)
        for scope in self._sources.functions:
            self._callback(scope)
        for row in self._flow.handled:
            self._note(row.message, "likely", row.place)
        messages = [self._message(key, uses) for key, uses in self._uses.items()]
        return tuple(
            sorted((message for message in messages if message is not None), key=lambda message: message.place)
        )

    def _note(self, scope: Scope, kind: str, place: Place, channel: str = "") -> None:
        self._scopes[id(scope.node)] = scope
        uses = self._uses[id(scope.node)]
        getattr(uses, kind).append(place)
        if channel and channel not in uses.channels:
            uses.channels.append(channel)

    def _called(self, call: Call, inside: set[str]) -> None:
        name, node = last_name(call.node.func).strip("_"), call.node
        place, receiver = call.module.place(node), _receiver(node)
        if name == "isinstance" and len(node.args) == 2:
            self._tested(call.module, call.scope, node.args[1], node.args[0])
        is_queue = name in ("put", "put_nowait", "get", "get_nowait")
        if is_queue and receiver in inside:
            return
        if name in SAYS or (
            receiver == "" and any(name.startswith(f"{verb}_") for verb in ("publish", "send", "emit"))
        ):
            for argument in (*node.args, *(keyword.value for keyword in node.keywords)):
                for scope in self._classes.classes_in(argument, call.module, call.scope):
                    self._note(scope, "said", place, receiver if is_queue else "")
        if name in SUBSCRIBES:
            for argument in (*node.args, *(keyword.value for keyword in node.keywords)):
                parts = argument.elts if isinstance(argument, ast.Tuple | ast.List) else [argument]
                for part in parts:
                    own = self._sources.class_of(call.module, part)
                    if own is not None and form_of(self._sources, own):
                        self._note(own, "heard", place)

    def _tested(self, module: Module, scope: Scope | None, classes: ast.expr, value: ast.expr | None) -> None:
        """`isinstance(message, Order)` or `case Order():` of what was taken from somewhere."""
        parts = classes.elts if isinstance(classes, ast.Tuple) else [classes]
        if value is not None and not self._is_taken(value, module, scope):
            return
        for part in parts:
            own = self._sources.class_of(module, part)
            if own is not None and form_of(self._sources, own) not in ("", "enum"):
                self._note(own, "likely", module.place(part))

    def _is_taken(self, value: ast.expr, module: Module, scope: Scope | None) -> bool:
        for node, _, at in self._flow.expressions(value, module, scope):
            if isinstance(node, ast.Call) and last_name(node.func).strip("_") in TAKES:
                return True
            if isinstance(node, ast.Name) and at is not None and not isinstance(at.node, ast.ClassDef):
                is_public = not at.node.name.startswith("_") or CALLBACK.search(at.node.name) is not None
                if is_public and node.id in parameter_names(at.node):
                    return True
        return False

    def _annotated(self, module: Module, scope: Scope | None, node: ast.AnnAssign | ast.arg, inside: set[str]) -> None:
        """`inbox: Queue[Order]`, of which the code takes, or to which it adds."""
        annotation = _unquoted(node.annotation)
        if not isinstance(annotation, ast.Subscript):
            return
        last = dotted_name(annotation.value).rpartition(".")[2]
        if last not in (
            "Queue",
            "SimpleQueue",
            "Subscription",
            "Inbox",
            "Publisher",
            "Topic",
            "Channel",
            "Sink",
            "Source",
        ):
            return
        name = node.arg if isinstance(node, ast.arg) else dotted_name(node.target).rpartition(".")[2]
        key = name.strip("_")
        if key in inside:
            return
        puts, gets = self._sides(key)
        for own in self._classes.in_annotation(
            annotation.slice if not isinstance(annotation.slice, ast.Tuple) else None, module
        ):
            if gets:
                self._note(own, "heard", gets[0], key)
            if puts:
                self._note(own, "said", puts[0], key)

    def _sides(self, key: str) -> tuple[list[Place], list[Place]]:
        puts, gets = [], []
        for module, _, node in self._flow.nodes:
            if isinstance(node, ast.Call) and _receiver(node) == key:
                if last_name(node.func) in ("put", "put_nowait", "publish", "send"):
                    puts.append(module.place(node))
                elif last_name(node.func) in TAKES:
                    gets.append(module.place(node))
            elif (
                isinstance(node, ast.AsyncFor | ast.For) and dotted_name(node.iter).rpartition(".")[2].strip("_") == key
            ):
                gets.append(module.place(node))
        return puts, gets

    def _inside_queues(self) -> set[str]:
        """Queues to which the code adds, and from which it takes itself."""
        names = {_receiver(call.node) for verb in ("put", "put_nowait") for call in self._flow.calls.get(verb, ())}
        return {name for name in names if name and all(self._sides(name))}

    def _callback(self, scope: Scope) -> None:
        function = scope.node
        assert not isinstance(function, ast.ClassDef)
        if not CALLBACK.search(function.name):
            return
        for part in (*function.args.posonlyargs, *function.args.args):
            for own in self._classes.in_annotation(part.annotation, scope.module):
                self._note(own, "likely", scope.place)

    def _message(self, key: int, uses: Uses) -> Message | None:
        scope = self._scopes[key]
        heard = uses.heard or ([] if uses.said else uses.likely)
        if not heard and not uses.said:
            return None
        if len(uses.channels) == 0 and form_of(self._sources, scope) == "enum" and not uses.heard:
            return None  # a member among the arguments of a message
        direction: Direction = "both" if heard and uses.said else "heard" if heard else "said"
        assert isinstance(scope.node, ast.ClassDef)
        return Message(
            scope.node.name,
            snake(scope.node.name),
            scope.module.name,
            direction,
            self._fields.fields(scope),
            scope.place,
            tuple(dict.fromkeys((*heard, *uses.said))),
            form_of(self._sources, scope),
            uses.channels[0] if uses.channels else "",
            certainty="certain" if uses.heard or uses.said else "likely",
        )


def _receiver(node: ast.Call) -> str:
    """On what a method is called, its last name without underscores: `self._jobs.put(1)` -> `jobs`."""
    if not isinstance(node.func, ast.Attribute):
        return ""
    return dotted_name(node.func.value).rpartition(".")[2].strip("_")


def _unquoted(annotation: ast.expr | None) -> ast.expr | None:
    """An annotation that is written as a text, as what it says."""
    if isinstance(annotation, ast.Constant) and isinstance(annotation.value, str):
        try:
            return ast.parse(annotation.value, mode="eval").body
        except SyntaxError:
            return None
    return annotation
