"""Finds stimuli without a message class: methods and callbacks of the code, and dicts and strings that it takes.

Each becomes a message of the draft, with an expression that converts it to what the code gets.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import replace
from itertools import product

from pytest_hricdv.extra.draft.code.classes import (
    find_message_classes,
    find_parameter_classes,
    methods_of,
    neutral_value,
    parse_annotation,
)
from pytest_hricdv.extra.draft.code.constants import is_enum
from pytest_hricdv.extra.draft.code.contents import Argument, ContentReader
from pytest_hricdv.extra.draft.code.fields import FieldReader
from pytest_hricdv.extra.draft.code.flow import Flow, last_name, parameters_of
from pytest_hricdv.extra.draft.code.handovers import Handovers, connection_of, last_part
from pytest_hricdv.extra.draft.code.naming import camel, snake, word
from pytest_hricdv.extra.draft.code.sources import Scope, Sources, name_with_dots
from pytest_hricdv.extra.draft.code_model import OWN_MODULE, Entry, Imports, Message, Port

ENDS = ("stop", "close", "shutdown", "join", "cancel", "quit", "exit", "terminate", "disconnect")
"""Methods that end the work of an object: nothing is called after them."""


class StimulusReader:
    """Finds the stimuli of an entry, for `CodeReader`."""

    def __init__(self, sources: Sources, flow: Flow) -> None:
        self._sources, self._flow = sources, flow
        self._fields = FieldReader(sources, flow)
        self._contents = ContentReader(flow, self._fields)

    def methods(self, entry: Entry, called: frozenset[str] = frozenset()) -> Iterator[Message]:
        """The public methods of the entry's object, and those in `called`, which were seen called from outside."""
        scope = self._sources.class_named(entry.module, entry.name)
        own = methods_of(self._sources, scope) if scope is not None else {}
        run = own.get(entry.method)
        for name, method in own.items():
            is_open = not (name == entry.method or name.startswith("_") or is_reader(method) or _decorators(method))
            if not is_open or connection_of(self._flow, method):
                continue
            is_step = run is not None and any(name_with_dots(node) == f"self.{name}" for node in ast.walk(run.node))
            if (name in called and not is_step) or not (name in ENDS or self._is_used(method)):
                yield from self._messages(name, method, name)

    def callbacks(self, entry: Entry) -> Iterator[Message]:
        """Methods of the entry's object that it hands to somebody: as an argument, or by an assignment."""
        scope = self._sources.class_named(entry.module, entry.name)
        methods = methods_of(self._sources, scope) if scope is not None else {}
        handovers = Handovers(self._sources, self._flow)
        owners = {id(method.owner) for method in methods.values()}
        for name, method in methods.items():
            if name != entry.method and not (_decorators(method) or connection_of(self._flow, method)):
                title = handovers.title(method, owners)
                if title:
                    yield from self._messages(title, method, name)

    def handlers(self, entry: Entry) -> Iterator[Message]:
        """Methods with which the object itself handles its input: they distinguish its kinds."""
        scope = self._sources.class_named(entry.module, entry.name)
        for name, method in methods_of(self._sources, scope).items() if scope is not None else ():
            assert not isinstance(method.node, ast.ClassDef)
            if name == entry.method or name.startswith("__") or _decorators(method):
                continue
            parameters = parameters_of(method.node)[1:]
            if parameters and self._is_used(method):
                made = list(self._messages(name, method, name))
                yield from (message for message in made if message.module != OWN_MODULE or len(made) > 1)

    def functions(self) -> Iterator[Message]:
        """Functions that the code registers by a decorator with a text, or hands to somebody."""
        handovers = Handovers(self._sources, self._flow)
        for function in self._sources.functions:
            module, node = function.module, function.node
            if module.scope.get(node.name) is not node or connection_of(self._flow, function):
                continue
            first = [part for call in node.decorator_list if isinstance(call, ast.Call) for part in call.args[:1]]
            texts = [part.value for part in first if isinstance(part, ast.Constant) and isinstance(part.value, str)]
            title = (last_part(texts[0]) or node.name) if texts else handovers.title(function)
            if title:
                yield from self._messages(title, function, f"{module.name}:{node.name}")

    def callback(self, name: str, function: Scope) -> Iterator[Message]:
        """A function of the code that it was seen to hand to a port."""
        title = last_part(name.partition(" ")[2]) or name.rpartition(".")[2].removeprefix("on_").removeprefix("set_")
        yield from self._messages(title, function, name, "CallbackCall")

    def items(self, port: Port, methods: tuple[str, ...]) -> Iterator[Message]:
        """Messages for the dicts and JSON without a class that the code takes from a port.

        Args:
            port: a queue or device.
            methods: its methods that return something.
        """
        for module, scope, node in self._flow.nodes:
            is_call = isinstance(node, ast.Call) and last_name(node.func) in methods
            if not isinstance(node, ast.Call | ast.AsyncFor) or scope is None or isinstance(node, ast.Call) != is_call:
                continue
            owner = name_with_dots(node.func if isinstance(node, ast.Call) else node.iter).split(".")
            owner = owner[:-1] if is_call else owner
            is_own = bool(owner) and owner[-1].strip("_") == port.name.strip("_")
            if not is_own and port.role != "connection":  # which is also read under the names of its parts
                continue
            variants = self._contents.variants_of_result(scope, node)
            channel = {"queue": port.name.strip("_"), "connection": port.name}.get(
                port.role, f"{port.name}.{last_name(getattr(node, 'func', node))}")  # fmt: skip
            for name, argument in variants:
                title = camel(word(last_part(name))) if name else camel(channel.replace(".", "_").strip("_")) + "Item"
                if argument.fields or name:
                    yield Message(title, snake(title), OWN_MODULE, "received", argument.fields, module.location(node),
                                  (module.location(node),), "item", channel, f"lambda m: {argument.source}",
                                  argument.imports)  # fmt: skip
            if variants:
                return

    def messages_in_list(self, port: Port) -> Iterator[Message]:
        """Messages in a list that a port has, as of what a control loop is given: `inputs.commands: list[Command]`."""
        for operation in port.operations:
            module = next((module for module in self._sources.modules if module.file == operation.location.file), None)
            written = ast.parse(operation.returns or "None", mode="eval").body
            if module is None or operation.is_method or not isinstance(written, ast.Subscript):
                continue
            for own in find_message_classes(self._sources, written.slice, module):
                name = own.node.name
                yield Message(name, snake(name), own.module.name, "received", self._fields.fields(own), own.location,
                              (operation.location,), "item", f"{port.name}.{operation.name}",
                              "lambda m: m")  # fmt: skip

    def convert(self, message: Message) -> Message:
        """A message whose class the bus of a test cannot carry, an enumeration or a typed dict, as one that it can."""
        title, names = f"{message.name}Item", [part.name for part in message.fields]
        imports: Imports = ()
        if message.form == "enum":
            source, imports = f"member({message.name}, m.name)", ((message.module, message.name),)
        else:
            source = "{" + ", ".join(f"{name!r}: m.{name}" for name in names) + "}"
        return replace(message, name=title, topic=snake(title), module=OWN_MODULE, form="item",
                       delivery=f"lambda m: {source}", delivery_imports=imports)  # fmt: skip

    def _is_used(self, method: Scope) -> bool:
        """Whether an object calls its method itself, or hands it to somebody: this is how it works inside."""
        name = method.node.name
        for _, at, node in self._flow.nodes:
            if isinstance(node, ast.Attribute) and node.attr == name and name_with_dots(node.value) == "self":
                owner = Scope(at.module, at.owner) if at is not None and at.owner is not None else None
                if owner is not None and methods_of(self._sources, owner).get(name) == method:
                    return True
        return False

    # --- functions and their parameters

    def _messages(self, name: str, scope: Scope, called: str, how: str = "MethodCall") -> Iterator[Message]:
        """A message for the call of a function, or one for each class of messages that it takes."""
        assert not isinstance(scope.node, ast.ClassDef)
        parameters = _caller_parameters(scope)
        positional = [part for part in parameters if part not in scope.node.args.kwonlyargs]
        required = len(positional) - len(scope.node.args.defaults)
        passed = [part for number, part in enumerate(parameters)
                  if number < required or self._fields.parameter(scope, part.arg, None).kind]  # fmt: skip
        classes = find_parameter_classes(self._sources, scope, passed[0]) if len(passed) == 1 else []
        for own in classes:  # messages of the code itself
            yield Message(own.node.name, snake(own.node.name), own.module.name, "received", self._fields.fields(own),
                          own.location, (scope.location,), "call", scope.node.name,
                          f"{how}({called!r}, lambda m: (m,))")  # fmt: skip
        if classes:
            return
        choices = [self._arguments(scope, part) for part in passed]
        for combination in product(*choices):
            named = [kind for kind, _ in combination if kind]
            arguments = [argument for _, argument in combination]
            title = camel(word(last_part(named[0]) if named else name.strip("_")))
            fields = {part.name: part for argument in arguments for part in argument.fields}
            sources = "".join(f"{argument.source}, " for argument in arguments).rstrip(" ")
            made = f"{how}({called!r}, lambda m: ({sources}))" if arguments else f"{how}({called!r})"
            imports = tuple(dict.fromkeys(need for argument in arguments for need in argument.imports))
            yield Message(title, snake(title), OWN_MODULE, "received", tuple(fields.values()), scope.location,
                          (scope.location,), "call", scope.node.name, made, imports)  # fmt: skip

    def _arguments(self, scope: Scope, part: ast.arg) -> list[tuple[str, Argument]]:
        """The variants of a parameter, each with its text; a single variant has an empty string."""
        annotation = parse_annotation(part.annotation)
        is_open = annotation is None or name_with_dots(annotation) in ("dict", "str", "bytes", "object", "Any")
        is_open |= isinstance(annotation, ast.Subscript) and name_with_dots(annotation.value) in ("dict", "Mapping")
        variants = self._contents.variants(scope, part.arg) if is_open else []
        return variants or [("", self._argument(scope, part))]

    def _argument(self, scope: Scope, part: ast.arg) -> Argument:
        assert not isinstance(scope.node, ast.ClassDef)
        annotation = parse_annotation(part.annotation)
        own = self._sources.class_of(scope.module, annotation)
        field = self._fields.parameter(scope, part.arg, annotation)
        if own is not None and is_enum(self._sources, own):
            name = own.node.name
            return Argument(f"member({name}, m.{part.arg})", (field,), ((own.module.name, name),))
        if field.kind:
            return Argument(f"m.{part.arg}", (field,))
        neutral, imports = neutral_value(self._sources, scope.module, annotation) or (
            f"unknown('{scope.node.name}.{part.arg}')",
            (),
        )
        return Argument(neutral, (), imports)


def _decorators(method: Scope) -> bool:
    """Whether a method is a property, or belongs to the class."""
    names = {last_name(decorator) for decorator in method.node.decorator_list}
    return bool(names & {"property", "setter", "staticmethod", "classmethod", "abstractmethod", "cached_property"})


def is_reader(method: Scope) -> bool:
    """Whether a method returns something and changes nothing: it sets nothing, and calls nothing for its effect."""
    returns = False
    for node in ast.walk(method.node):
        if isinstance(node, ast.Attribute | ast.Subscript) and not isinstance(node.ctx, ast.Load):
            return False
        if isinstance(node, ast.Await | ast.Yield | ast.YieldFrom | ast.Raise):
            return False
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
            return False
        returns |= isinstance(node, ast.Return) and node.value is not None
    return returns


def _caller_parameters(scope: Scope) -> list[ast.arg]:
    """The parameters that a caller fills."""
    assert not isinstance(scope.node, ast.ClassDef)
    parameters = parameters_of(scope.node)
    return parameters[1:] if parameters and parameters[0].arg in ("self", "cls") else parameters
