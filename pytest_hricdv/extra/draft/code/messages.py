"""Finds the messages of the code: classes whose instances it publishes, puts into queues, or takes from them."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field

from pytest_hricdv.extra.draft.code.classes import find_message_classes, form_of, parse_annotation
from pytest_hricdv.extra.draft.code.constants import is_enum
from pytest_hricdv.extra.draft.code.fields import FieldReader
from pytest_hricdv.extra.draft.code.flow import CallSite, Flow, annotation_of, last_name, parameter_names
from pytest_hricdv.extra.draft.code.naming import snake
from pytest_hricdv.extra.draft.code.sources import Module, Scope, Sources, name_with_dots
from pytest_hricdv.extra.draft.code_model import CodeLine, Direction, Message

PUBLISHES = ("publish", "put", "put_nowait", "send", "emit")
"""Calls that hand a message on: of a bus, and of queues."""

TAKES = ("get", "get_nowait", "wait", "poll", "recv")
"""Calls that return a message: of a subscription, and of queues."""

_QUEUES = ("Queue", "SimpleQueue", "PriorityQueue", "Subscription")


@dataclass
class _Uses:
    """The places where a class is published and received; `tested` are the isinstance checks."""

    published: list[CodeLine] = field(default_factory=list)
    received: list[CodeLine] = field(default_factory=list)
    tested: list[CodeLine] = field(default_factory=list)
    channels: list[str] = field(default_factory=list)


class MessageFinder:
    """Finds the classes that are messages, for `analyse_sources`."""

    def __init__(self, sources: Sources, flow: Flow) -> None:
        self._sources, self._flow = sources, flow
        self._fields = FieldReader(sources, flow)
        self._uses: dict[int, _Uses] = defaultdict(_Uses)
        self._scopes: dict[int, Scope] = {}

    def messages(self) -> tuple[Message, ...]:
        """All messages, in the order of the code."""
        for module, scope, node in self._flow.nodes:
            if isinstance(node, ast.Call):
                self._read_call(CallSite(module, scope, node))
            elif isinstance(node, ast.MatchClass):
                self._read_test(module, node.cls)
            elif isinstance(node, ast.AnnAssign | ast.arg) and node.annotation is not None:
                self._read_annotation(module, node)
        messages = [self._message(key, uses) for key, uses in self._uses.items()]
        return tuple(sorted((made for made in messages if made is not None), key=lambda message: message.location))

    def _note(self, scope: Scope, side: str, location: CodeLine, channel: str = "") -> None:
        self._scopes[id(scope.node)] = scope
        uses = self._uses[id(scope.node)]
        getattr(uses, side).append(location)
        if channel and channel not in uses.channels:
            uses.channels.append(channel)

    def _read_call(self, call: CallSite) -> None:
        name, node = last_name(call.node.func).strip("_"), call.node
        location, receiver = call.module.location(node), _receiver(node)
        arguments = [*node.args, *(keyword.value for keyword in node.keywords)]
        if name == "isinstance" and len(node.args) == 2 and self._is_taken(node.args[0], call):
            self._read_test(call.module, node.args[1])
        is_queue = name in ("put", "put_nowait")
        if name in PUBLISHES or self._is_port_call(call):
            for argument in arguments:
                for scope in self._classes_of(argument, call.module, call.scope):
                    self._note(scope, "published", location, receiver if is_queue else "")
        if name == "subscribe":
            for argument in arguments:
                for part in argument.elts if isinstance(argument, ast.Tuple | ast.List) else [argument]:
                    own = self._sources.class_of(call.module, part)
                    if own is not None and form_of(self._sources, own):
                        self._note(own, "received", location)

    def _is_port_call(self, call: CallSite) -> bool:
        """Whether a parameter, or an attribute that holds one, is itself called: `self._publish(Done())`."""
        for node, _, at in self._flow.expressions(call.node.func, call.module, call.scope):
            is_function = at is not None and not isinstance(at.node, ast.ClassDef)
            if is_function and isinstance(node, ast.Name) and node.id in parameter_names(at.node):  # type: ignore[union-attr, arg-type]
                return True
        return False

    def _read_test(self, module: Module, classes: ast.expr) -> None:
        """`isinstance(message, Order)` or `case Order():` of what the code has taken."""
        for part in classes.elts if isinstance(classes, ast.Tuple) else [classes]:
            own = self._sources.class_of(module, part)
            if own is not None and form_of(self._sources, own) not in ("", "enum"):
                self._note(own, "tested", module.location(part))

    def _is_taken(self, value: ast.expr, call: CallSite) -> bool:
        return any(isinstance(node, ast.Call) and last_name(node.func) in TAKES
                   for node, _, _ in self._flow.expressions(value, call.module, call.scope))  # fmt: skip

    def _read_annotation(self, module: Module, node: ast.AnnAssign | ast.arg) -> None:
        """`inbox: Queue[Order]`, of which the code takes, or to which it adds."""
        annotation = parse_annotation(node.annotation)
        if not isinstance(annotation, ast.Subscript) or isinstance(annotation.slice, ast.Tuple):
            return
        name = node.arg if isinstance(node, ast.arg) else name_with_dots(node.target).rpartition(".")[2]
        key = name.strip("_")
        if name_with_dots(annotation.value).rpartition(".")[2] in _QUEUES:
            puts, gets = self._sides(key)
            for own in find_message_classes(self._sources, annotation.slice, module):
                if gets:
                    self._note(own, "received", gets[0], key)
                if puts:
                    self._note(own, "published", puts[0], key)

    def _sides(self, queue: str) -> tuple[list[CodeLine], list[CodeLine]]:
        """The places where the code puts into a queue of this name, and where it takes from it."""
        puts: list[CodeLine] = []
        gets: list[CodeLine] = []
        for module, _, node in self._flow.nodes:
            if isinstance(node, ast.Call) and _receiver(node) == queue:
                name = last_name(node.func)
                (puts if name in PUBLISHES else gets if name in TAKES else []).append(module.location(node))
            elif isinstance(node, ast.AsyncFor | ast.For) and _name_of(node.iter) == queue:
                gets.append(module.location(node))
        return puts, gets

    def _classes_of(self, expression: ast.expr, module: Module, scope: Scope | None) -> Iterator[Scope]:
        """Message classes whose instances (or members) an expression can be."""
        for node, where, at in self._flow.expressions(expression, module, scope):
            own = None
            if isinstance(node, ast.Call):
                own = self._sources.class_of(where, node.func)
                if last_name(node.func) in ("replace", "copy", "deepcopy") and node.args:
                    yield from self._classes_of(node.args[0], where, at)
                for function in self._flow.methods.get(last_name(node.func), ()):
                    assert not isinstance(function.node, ast.ClassDef)
                    yield from find_message_classes(self._sources, function.node.returns, function.module)
            elif isinstance(node, ast.Attribute):
                own = self._sources.class_of(where, node.value)
                own = own if own is not None and is_enum(self._sources, own) else None
            elif isinstance(node, ast.Name) and at is not None and not isinstance(at.node, ast.ClassDef):
                yield from find_message_classes(self._sources, annotation_of(at.node, node.id), at.module)
            if own is not None and form_of(self._sources, own):
                yield own

    def _message(self, key: int, uses: _Uses) -> Message | None:
        scope = self._scopes[key]
        received = uses.received or ([] if uses.published else uses.tested)
        form = form_of(self._sources, scope)
        if not received and not uses.published:
            return None
        if not uses.channels and form == "enum" and not uses.received:
            return None  # a member among the arguments of a message
        direction: Direction = "both" if received and uses.published else "received" if received else "published"
        assert isinstance(scope.node, ast.ClassDef)
        return Message(
            scope.node.name,
            snake(scope.node.name),
            scope.module.name,
            direction,
            self._fields.fields(scope),
            scope.location,
            tuple(dict.fromkeys((*received, *uses.published))),
            form,
            uses.channels[0] if uses.channels else "",
        )


def _receiver(node: ast.Call) -> str:
    """The receiver of a method call, its last name without underscores: `self._jobs.put(1)` -> `jobs`."""
    return _name_of(node.func.value) if isinstance(node.func, ast.Attribute) else ""


def _name_of(queue: ast.expr) -> str:
    return name_with_dots(queue).rpartition(".")[2].strip("_")
