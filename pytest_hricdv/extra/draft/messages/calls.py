"""Functions and methods of the code that somebody outside calls: a screen, a web server, a middleware, hardware.

They are drafted where nothing else is found that the code hears. What is called is a message with a field for each
argument, and for each key or attribute that is read of one.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from pytest_hricdv.extra.draft.found.findings import Calling, Entry, FoundValue, Machine, Message, MessageField, Place
from pytest_hricdv.extra.draft.messages.call_arguments import Argument, arguments_of, sent_by
from pytest_hricdv.extra.draft.messages.plain import Holder, messages_of
from pytest_hricdv.extra.draft.messages.plain_reader import PlainReader
from pytest_hricdv.extra.draft.messages.plain_value import PlainValue
from pytest_hricdv.extra.draft.reading.classes import methods_of
from pytest_hricdv.extra.draft.reading.naming import camel, snake
from pytest_hricdv.extra.draft.reading.sources import Function, Scope, Sources, dotted_name, imported_name
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow, parameter_names

LIBRARIES = ("transitions", "python-statemachine")
"""Libraries whose machines call methods by their names."""

STEPS = ("step", "tick", "update", "execute", "control", "loop", "spin")
"""Methods that something calls again and again, where they have no loop of their own."""

_OWN_WAYS = ("threading.", "asyncio.", "functools.", "multiprocessing.", "concurrent.", "atexit.", "signal.", "sched.",
             "property", "staticmethod", "classmethod", "map", "filter", "sorted", "min", "max", "dataclass",
             "contextlib.", "abc.", "typing.", "pytest.", "super", "isinstance", "print", "partial")  # fmt: skip
"""Who calls a function that it is handed within the code itself, or not at all."""

_HOOKS = ("on_enter_", "on_exit_", "on_transition", "after_", "before_", "on_")
"""Methods of a class with a machine of a library that this calls."""

_LISTENS = re.compile(
    r"^(add|register|attach|set|connect|remove|unregister)_?(listener|callback|observer|handler|hook)s?$"
)
"""Methods that take a function to call: a person has none to hand over."""

_RECEIVES = ("get_json", "json", "form", "args", "values", "data")
"""What is read of the request of a web framework."""


@dataclass(frozen=True)
class Called:
    """What was found.

    Args:
        entry: with what is called at once or again and again.
        messages: heard and said.
        calls: what is called for each message that is heard.
    """

    entry: Entry | None
    messages: tuple[Message, ...] = ()
    calls: tuple[Calling, ...] = ()


@dataclass
class CallFinder:
    """Finds what is called from outside."""

    sources: Sources
    flow: ValueFlow
    entry: Entry | None
    _messages: list[Message] = field(default_factory=list)
    _calls: list[Calling] = field(default_factory=list)

    def found(self, machines: tuple[Machine, ...]) -> Called:
        """The calls; triggers of state machines of a library are methods as well."""
        reader = PlainReader(self.sources, self.flow)
        entry = self._entry_within()
        hooks = _HOOKS if any(entry and machine.name == entry.name and machine.kind in LIBRARIES
                              for machine in machines) else ()  # fmt: skip
        for scope, owner in self._called(entry):
            if hooks and owner and scope.node.name.startswith(hooks):
                continue
            arguments = arguments_of(self.sources, self.flow, reader, scope)
            if arguments is not None:
                self._add(scope, owner, arguments, reader)
        names = {calling.target for calling in self._calls}
        for event, place in _events(machines, entry, self.flow):
            if f"made.{event}" not in names:
                message = _message(event, (), place)
                self._messages.append(message)
                self._calls.append(Calling(message.name, f"made.{event}", (), (), place))
        if self._calls and entry is not None and entry.name[:1].isupper():
            entry = replace(entry, stays=True)
        if self._calls:
            self._messages.append(_failure(self._calls))
        return Called(entry, tuple(self._messages), tuple(self._calls))

    def _entry_without_loop(self) -> Entry | None:
        """The entry; a method without a loop, and a function that has only plain parameters, are no programs."""
        entry = self.entry
        scope = self._entry_scope()
        if entry is None or scope is None or isinstance(scope.node, ast.ClassDef) or _loops(scope.node):
            return entry
        plain = [port for port in (entry.method_ports if entry.method else entry.ports) if not port.default]
        if not entry.method:
            return None if plain and all(port.role == "parameter" for port in plain) else entry
        if entry.method in STEPS and not plain:
            return replace(entry, is_step=True)
        waits = any(isinstance(node, ast.Await) for node in ast.walk(scope.node))
        if plain or (entry.method == "execute" and not waits):
            return replace(entry, method="", method_ports=(), stays=True)
        return entry

    def _entry_within(self) -> Entry | None:
        """The entry; None where it only starts a server of real sockets that calls functions of the code."""
        entry, scope = self._entry_without_loop(), self._entry_scope()
        if entry is not None and not entry.method and scope is not None and any(self._registered()):
            used = {imported_name(scope.module, node.func).partition(".")[0] for node in ast.walk(scope.node)
                    if isinstance(node, ast.Call)}  # fmt: skip
            if used & {"socket", "selectors", "http", "socketserver"}:
                return None
        return entry

    def _entry_scope(self) -> Scope | None:
        entry = self.entry
        if entry is None:
            return None
        for scope in self.sources.classes:
            if entry.method and scope.node.name == entry.name and scope.module.name == entry.module:
                return methods_of(self.sources, scope).get(entry.method)
        return next((s for s in self.sources.functions if s.node.name == entry.name and s.owner is None), None)

    # --- what is called

    def _called(self, entry: Entry | None) -> Iterator[tuple[Scope, bool]]:
        """Functions and methods with whether what the entry makes has them."""
        registered = {id(scope.node) for scope in self._registered()}
        own = next((s for s in self.sources.classes if entry is not None and s.node.name == entry.name), None)
        methods = methods_of(self.sources, own) if own is not None else {}
        skipped = {"__init__", entry.method if entry is not None else ""}
        for name, scope in methods.items():
            function = scope.node
            assert not isinstance(function, ast.ClassDef)
            if _LISTENS.match(name):
                continue
            is_loop = _loops(function) and id(function) not in registered
            is_public = not name.startswith("_") and not _is_plain_access(function) and not self._is_used(scope)
            if name not in skipped and (is_public or id(function) in registered) and not is_loop:
                yield scope, True
        is_own = {id(scope.node) for scope in methods.values()}
        has_program = entry is not None or bool(registered)
        for scope in self.sources.functions:
            function = scope.node
            assert not isinstance(function, ast.ClassDef)
            if scope.owner is not None or id(function) in is_own or function not in scope.module.tree.body:
                continue
            is_entry = entry is not None and not entry.method and function.name == entry.name
            is_free = not has_program and not function.name.startswith("_") and not self._is_called(scope)
            if not is_entry and (id(function) in registered or (is_free and not _loops(function))):
                yield scope, False

    def _is_used(self, scope: Scope) -> bool:
        """Whether the code calls it, or has it in a table, or hands it to a thread."""
        name = scope.node.name
        is_held = any(isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Load) and node.attr == name
                      and dotted_name(node.value) == "self" for _, _, node in self.flow.nodes)  # fmt: skip
        return is_held or self._is_called(scope)

    def _is_called(self, scope: Scope) -> bool:
        """Whether the code itself calls it; what its main program does, somebody outside may do."""
        calls = self.flow.calls.get(scope.node.name, ())
        return any(call.scope is not None and call.scope.node is not scope.node for call in calls)

    def _registered(self) -> Iterator[Scope]:
        """Functions that are handed to something outside of the code: as arguments, attributes, or decorated."""
        for module, scope, node in self.flow.nodes:
            handed: list[ast.expr] = []
            if isinstance(node, ast.Call):
                name = imported_name(module, node.func)
                is_own = self.sources.definition(module, dotted_name(node.func)) is not None
                is_method = isinstance(node.func, ast.Attribute) and self.flow.methods.get(node.func.attr)
                if not is_own and not is_method and not name.startswith(_OWN_WAYS):
                    handed = [*node.args, *(keyword.value for keyword in node.keywords)]
            elif isinstance(node, ast.Assign) and any(self._is_outside(target) for target in node.targets):
                handed = [node.value]
            elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                names = [imported_name(module, d.func if isinstance(d, ast.Call) else d) for d in node.decorator_list]
                if any("." in name and not name.startswith(_OWN_WAYS) and ".setter" not in name for name in names):
                    yield from (s for s in self.flow.methods[node.name] if s.node is node)
            for part in handed:
                yield from self._functions(part, scope)

    def _is_outside(self, target: ast.expr) -> bool:
        """`client.on_message = ...`: an attribute of what is not the object itself."""
        return isinstance(target, ast.Attribute) and dotted_name(target.value) not in ("", "self")

    def _functions(self, part: ast.expr, scope: Scope | None) -> Iterator[Scope]:
        name = dotted_name(part)
        if not isinstance(part, ast.Name | ast.Attribute) or not name:
            return
        head, _, last = name.rpartition(".")
        owner = scope.owner if scope is not None else None
        for other in self.flow.methods.get(last, ()):
            if (head == "self" and other.owner is owner) or (not head and other.owner is None):
                yield other

    def _add(self, scope: Scope, is_method: bool, arguments: tuple[Argument, ...], reader: PlainReader) -> None:
        function = scope.node
        assert not isinstance(function, ast.ClassDef)
        module = scope.module.name
        target = f"made.{function.name}" if is_method else f'import_module("{module}").{function.name}'
        message = _message(function.name, arguments, scope.place)
        said = tuple(self._returned(scope, function, reader))
        self._messages += [message, *said]
        sources = tuple(f"{part.keyword}={part.source}" if part.keyword else part.source for part in arguments)
        sources = tuple(part.replace("TALK(", f"calls.talk({message.name}, ") for part in sources)
        needs = tuple(need for part in arguments for need in part.needs)
        request = self._request(scope, function)
        self._calls.append(Calling(message.name, target, sources, tuple(m.name for m in said), scope.place,
                                   isinstance(function, ast.AsyncFunctionDef), needs, request))  # fmt: skip

    def _request(self, scope: Scope, function: Function) -> str:
        """The module whose `request` a function of a web framework reads; empty where it reads none."""
        uses = "jsonify" in scope.module.imports
        reads = uses or any(isinstance(node, ast.Attribute) and dotted_name(node.value) == "request"
                    and node.attr in _RECEIVES for node in ast.walk(function))  # fmt: skip
        return scope.module.name if reads and {"request", "jsonify"} & set(scope.module.imports) else ""

    def _returned(self, scope: Scope, function: Function, reader: PlainReader) -> Iterator[Message]:
        """What a function says by what it returns."""
        value, places = PlainValue(scope.place), []
        for node in _own_nodes(function):
            if isinstance(node, ast.Return) and node.value is not None:
                content = node.value
                if isinstance(content, ast.Tuple) and len(content.elts) == 2 and self._is_status(content.elts[1]):
                    content = content.elts[0]
                if isinstance(content, ast.Call) and dotted_name(content.func).endswith("jsonify") and content.args:
                    content = content.args[0]
                reader.write(content, scope.module, scope, value)
                places.append(scope.module.place(node))
        for name in parameter_names(function):
            for content in sent_by(scope, name):
                reader.write(content, scope.module, scope, value)
                places.append(scope.module.place(content))
        if places and value.is_known:
            yield from messages_of(Holder("call", "", function.name), "said", value, places)

    @staticmethod
    def _is_status(node: ast.expr) -> bool:
        return isinstance(node, ast.Constant) and isinstance(node.value, int) and 100 <= node.value < 600


def _message(name: str, arguments: tuple[Argument, ...], place: Place) -> Message:
    fields = {part.name: part for argument in arguments for part in argument.fields}
    made = camel(name.strip("_"))
    return Message(made, snake(made), "", "heard", tuple(fields.values()), place, (place,), "call", name,
                   paths=tuple((name,) for name in fields))  # fmt: skip


def _failure(calls: list[Calling]) -> Message:
    """What is said where the code answers a call by raising something."""
    place = calls[0].place
    values = tuple(FoundValue(calling.message, calling.place) for calling in calls)
    fields = (MessageField("call", "str", "str", place, values, default='""'),
              MessageField("error", "str", "str", place, default='""'))  # fmt: skip
    return Message("CallFailed", "call_failed", "", "said", fields, place, (place,), "failure", "call_failed",
                   paths=(("call",), ("error",)))  # fmt: skip


def _events(machines: tuple[Machine, ...], entry: Entry | None, flow: ValueFlow) -> Iterator[tuple[str, Place]]:
    """Events of the entry's own machine that the code does not cause itself."""
    for machine in machines:
        if entry is not None and machine.name == entry.name and machine.kind in LIBRARIES:
            for move in machine.transitions:
                if move.event.isidentifier() and not flow.calls.get(move.event):
                    yield move.event, move.place
    return


def _loops(function: Function) -> bool:
    """Whether a function has a loop that may last: it is a program, and nobody waits for its end."""
    return any(isinstance(node, ast.While | ast.AsyncFor) for node in _own_nodes(function))


def _own_nodes(function: Function) -> Iterator[ast.AST]:
    waiting: list[ast.AST] = list(function.body)
    while waiting:
        node = waiting.pop(0)
        yield node
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda | ast.ClassDef):
            waiting += ast.iter_child_nodes(node)


def _is_plain_access(function: Function) -> bool:
    """A property, or a method that only hands out an attribute."""
    names = {dotted_name(d.func if isinstance(d, ast.Call) else d).rpartition(".")[2] for d in function.decorator_list}
    if names & {"property", "setter", "cached_property", "abstractmethod", "overload"}:
        return True
    body = [s for s in function.body if not (isinstance(s, ast.Expr) and isinstance(s.value, ast.Constant))]
    is_read = len(body) == 1 and isinstance(body[0], ast.Return) and isinstance(body[0].value, ast.Attribute | ast.Name)
    return is_read and len(parameter_names(function)) <= 1
