"""What makes code act that no message class describes: its methods, its callbacks, and dicts and texts that it takes.

Each becomes a message of the draft, with the expression that makes of it what the code gets.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import replace

from pytest_hricdv.extra.draft.code.classes import form_of, methods_of, neutral_value, parse_annotation
from pytest_hricdv.extra.draft.code.constants import is_enum
from pytest_hricdv.extra.draft.code.contents import Argument, ContentReader, kind_of, with_constants
from pytest_hricdv.extra.draft.code.fields import FieldReader
from pytest_hricdv.extra.draft.code.flow import Flow, last_name, parameters_of
from pytest_hricdv.extra.draft.code.naming import camel, snake, word
from pytest_hricdv.extra.draft.code.sources import Scope, Sources, name_with_dots
from pytest_hricdv.extra.draft.code.usage import Usage
from pytest_hricdv.extra.draft.code_model import OWN_MODULE, Entry, Imports, Message, Port

MESSAGE_FORMS = ("dataclass", "namedtuple", "model")
"""Forms of classes that the bus of a test carries."""

ENDS = ("stop", "close", "shutdown", "join", "cancel", "quit", "exit", "terminate", "disconnect")
"""Methods that end the work of an object are the last thing that anybody calls."""


class StimulusReader:
    """Reads what makes code act."""

    def __init__(self, sources: Sources, flow: Flow, usage: Usage) -> None:
        self._sources, self._flow, self._usage = sources, flow, usage
        self._fields = FieldReader(sources, flow)
        self._contents = ContentReader(flow, self._fields, usage)

    def methods(self, entry: Entry, called: frozenset[str] = frozenset()) -> Iterator[Message]:
        """The public methods of the entry's object, and those that were called from outside.

        Args:
            entry: of the code.
            called: names of methods that were seen to be called from outside.
        """
        scope = self._scope_of(entry)
        for name, method in methods_of(self._sources, scope).items() if scope is not None else ():
            is_open = (
                not name.startswith("_") and name not in ENDS and not _is_reader(method) and not self._is_used(name)
            )
            if name != entry.method and (name in called or is_open) and not _decorators(method):
                yield self._message(name, method, f"MethodCall({name!r}, ", 1)

    def callbacks(self, entry: Entry) -> Iterator[Message]:
        """Functions of the code that it hands to its ports: `driver.on_button(self._pressed)`."""
        for port in (*entry.ports, *entry.method_ports):
            for operation in port.operations if port.role in ("device", "bus") else ():
                for text, function in operation.callbacks:
                    scope = self._function(entry, function)
                    if scope is None:
                        continue
                    name = text or operation.name.removeprefix("on_").removeprefix("set_") or operation.name
                    where = f"{port.name}.{operation.name}" + (f" {text}" if text else "")
                    skip = 1 if scope.owner is not None else 0
                    yield self._message(f"{name}", scope, f"CallbackCall({where!r}, ", skip)

    def items(self, port: Port, methods: tuple[str, ...]) -> Iterator[Message]:
        """Messages for the dicts and JSON without a class that the code takes from a port.

        Args:
            port: a queue or device.
            methods: of it that return something.
        """
        for module, scope, node in self._flow.nodes:
            if not isinstance(node, ast.Call) or scope is None or last_name(node.func) not in methods:
                continue
            owner = name_with_dots(node.func).split(".")
            if len(owner) < 2 or owner[-2].strip("_") != port.name.strip("_"):
                continue
            argument = self._contents.of_result(scope, node)
            if argument is not None:
                title = camel(port.name.strip("_")) + "Item"
                channel = port.name.strip("_") if port.role == "queue" else f"{port.name}.{last_name(node.func)}"
                yield Message(title, snake(title), OWN_MODULE, "received", argument.fields, module.location(node),
                              (module.location(node),), "item", channel, f"lambda m: {argument.source}",
                              argument.imports)  # fmt: skip
                return

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

    def _is_used(self, name: str) -> bool:
        """Whether the code itself calls a method, or hands it to somebody: then this is how it works inside."""
        handed = any(isinstance(node, ast.Attribute) and node.attr == name and isinstance(node.ctx, ast.Load)
                     for _, _, node in self._flow.nodes)  # fmt: skip
        return handed or bool(self._flow.calls.get(name))

    # --- functions and their parameters

    def _scope_of(self, entry: Entry) -> Scope | None:
        return next((scope for scope in self._sources.classes
                     if (scope.module.name, scope.node.name) == (entry.module, entry.name)), None)  # fmt: skip

    def _function(self, entry: Entry, function: str) -> Scope | None:
        scope = self._scope_of(entry)
        own = methods_of(self._sources, scope).get(function) if scope is not None else None
        others = self._flow.methods.get(function, [])
        return own or (others[0] if len(others) == 1 else None)

    def _message(self, name: str, scope: Scope, call: str, skip: int) -> Message:
        """A message for a call of a function."""
        assert not isinstance(scope.node, ast.ClassDef)
        parameters = parameters_of(scope.node)[skip:]
        positional = [*scope.node.args.posonlyargs, *scope.node.args.args][skip:]
        required = len(positional) - len(scope.node.args.defaults)
        arguments = [self._argument(scope, part, number) for number, part in enumerate(parameters)
                     if number < required or self._is_passed(scope.node.name, number, part.arg)]  # fmt: skip
        alone = arguments[0] if len(arguments) == 1 else None
        if alone is not None and alone.source == "m":  # a message of the code itself
            own = self._sources.class_of(scope.module, parse_annotation(parameters[0].annotation))
            assert own is not None
            how = f"{call}lambda m: (m,))"
            return Message(own.node.name, snake(own.node.name), own.module.name, "received", alone.fields,
                           own.location, (scope.location,), "call", scope.node.name, how)  # fmt: skip
        title = camel(word(name))
        fields = {part.name: part for argument in arguments for part in argument.fields}
        sources = "".join(f"{argument.source}, " for argument in arguments).rstrip(" ")
        made = f"{call}lambda m: ({sources}))" if arguments else f"{call.removesuffix(', ')})"
        imports = tuple(dict.fromkeys(need for argument in arguments for need in argument.imports))
        return Message(title, snake(title), OWN_MODULE, "received", tuple(fields.values()), scope.location,
                       (scope.location,), "call", scope.node.name, made, imports)  # fmt: skip

    def _is_passed(self, function: str, number: int, name: str) -> bool:
        """Whether programs pass a parameter that has a default."""
        return bool(self._usage.values(function, number, name))

    def _argument(self, scope: Scope, part: ast.arg, number: int) -> Argument:
        assert not isinstance(scope.node, ast.ClassDef)
        annotation = parse_annotation(part.annotation)
        own = self._sources.class_of(scope.module, annotation)
        if own is not None and form_of(self._sources, own) in MESSAGE_FORMS and _is_top_level(own):
            return Argument("m", self._fields.fields(own))
        known = self._usage.values(scope.node.name, number, part.arg)
        field = self._fields.parameter(scope, part.arg, annotation)
        if own is not None and is_enum(self._sources, own):
            name = own.node.name
            return Argument(f"member({name}, m.{part.arg})", (field,), ((own.module.name, name),))
        if field.kind:
            return Argument(f"m.{part.arg}", (with_constants(field, known),))
        if annotation is None:
            unknown = self._contents.of_name(scope, part.arg)
            if unknown is not None:
                return unknown
            field = with_constants(replace(field, kind=kind_of(known, field)), known)
            if field.kind:
                return Argument(f"m.{part.arg}", (field,))
        neutral, imports = neutral_value(self._sources, scope.module, annotation) or ("Neutral()", ())
        return Argument(neutral, (), imports)


def _decorators(method: Scope) -> bool:
    """Whether a method is a property, or belongs to the class."""
    names = {last_name(each) for each in method.node.decorator_list}
    return bool(names & {"property", "setter", "staticmethod", "classmethod", "abstractmethod", "cached_property"})


def _is_reader(method: Scope) -> bool:
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


def _is_top_level(scope: Scope) -> bool:
    return scope.module.scope.get(scope.node.name) is scope.node
