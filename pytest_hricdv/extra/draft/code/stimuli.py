"""What makes code act that no message class describes: its methods, its callbacks, and dicts and texts that it takes.

Each becomes a message of the draft, with the expression that makes of it what the code gets.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, replace

from pytest_hricdv.extra.draft.code.classes import form_of, methods_of, neutral_value, parse_annotation
from pytest_hricdv.extra.draft.code.constants import is_enum
from pytest_hricdv.extra.draft.code.fields import FieldReader
from pytest_hricdv.extra.draft.code.flow import Flow, last_name, parameters_of
from pytest_hricdv.extra.draft.code.naming import camel, snake, word
from pytest_hricdv.extra.draft.code.sources import Function, Scope, Sources, name_with_dots
from pytest_hricdv.extra.draft.code.usage import Usage
from pytest_hricdv.extra.draft.code_model import OWN_MODULE, Entry, FieldValue, Imports, Message, MessageField, Port

MESSAGE_FORMS = ("dataclass", "namedtuple", "model")
"""Forms of classes that the bus of a test carries."""

MAX_HANDOVERS = 2
"""Calls through which a dict is followed."""

ENDS = ("stop", "close", "shutdown", "join", "cancel", "quit", "exit", "terminate", "disconnect")
"""Methods that end the work of an object are the last thing that anybody calls."""


@dataclass(frozen=True)
class _Argument:
    """What a parameter gets: the fields of the message from which an expression makes it."""

    source: str
    fields: tuple[MessageField, ...] = ()
    imports: Imports = ()


class StimulusReader:
    """Reads what makes code act."""

    def __init__(self, sources: Sources, flow: Flow, usage: Usage) -> None:
        self._sources, self._flow, self._usage = sources, flow, usage
        self._fields = FieldReader(sources, flow)

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
        """A dict or JSON that the code takes from a port without saying of which class it is.

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
            argument = self._of_result(scope, node)
            if argument is not None:
                title = camel(port.name.strip("_")) + "Item"
                channel = port.name.strip("_") if port.role == "queue" else f"{port.name}.{last_name(node.func)}"
                yield Message(title, snake(title), OWN_MODULE, "received", argument.fields, module.location(node),
                              (module.location(node),), "item", channel, f"lambda m: {argument.source}",
                              argument.imports)  # fmt: skip
                return

    def _of_result(self, scope: Scope, node: ast.Call) -> _Argument | None:
        """What a call returns, by what is done with it: under a name, or as an argument of a function of the code."""
        for name in self._names_of(node):
            argument = self._of_unknown(scope, name)
            if argument is not None:
                return argument
        return None

    def converted(self, message: Message) -> Message:
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

    def _argument(self, scope: Scope, part: ast.arg, number: int) -> _Argument:
        assert not isinstance(scope.node, ast.ClassDef)
        annotation = parse_annotation(part.annotation)
        own = self._sources.class_of(scope.module, annotation)
        if own is not None and form_of(self._sources, own) in MESSAGE_FORMS and _is_top_level(own):
            return _Argument("m", self._fields.fields(own))
        known = self._usage.values(scope.node.name, number, part.arg)
        field = self._fields.parameter(scope, part.arg, annotation)
        if own is not None and is_enum(self._sources, own):
            name = own.node.name
            return _Argument(f"member({name}, m.{part.arg})", (field,), ((own.module.name, name),))
        if field.kind:
            return _Argument(f"m.{part.arg}", (_with_constants(field, known),))
        if annotation is None:
            unknown = self._of_unknown(scope, part.arg)
            if unknown is not None:
                return unknown
            field = _with_constants(replace(field, kind=_kind_of(known, field)), known)
            if field.kind:
                return _Argument(f"m.{part.arg}", (field,))
        neutral, imports = neutral_value(self._sources, scope.module, annotation) or ("Anything()", ())
        return _Argument(neutral, (), imports)

    def _names_of(self, node: ast.AST) -> Iterator[str]:
        """The names that get a value, also through `json.loads`."""
        parent = self._flow.parents.get(id(node))
        while isinstance(parent, ast.Await | ast.Call | ast.Attribute):
            parent = self._flow.parents.get(id(parent))
        targets = parent.targets if isinstance(parent, ast.Assign) else []
        yield from (target.id for target in targets if isinstance(target, ast.Name))
        if isinstance(parent, ast.AnnAssign | ast.NamedExpr) and isinstance(parent.target, ast.Name):
            yield parent.target.id

    def _of_unknown(self, scope: Scope, name: str) -> _Argument | None:
        """A dict whose keys the code reads, JSON of one, or an object whose attributes it reads."""
        keys = self._keys(scope, name)
        if keys:
            return _Argument(_dict_source(keys), _known(keys))
        for node in ast.walk(scope.node):
            is_loads = isinstance(node, ast.Call) and last_name(node.func) == "loads" and node.args
            if not is_loads or not isinstance(node, ast.Call):
                continue
            inner = node.args[0]
            is_bytes = "decode" in ast.unparse(inner)
            path = ast.unparse(inner).removesuffix(".decode()").partition(".decode(")[0]
            keys = [key for target in self._names_of(node) for key in self._keys(scope, target)]
            keys = keys or self._keys_of_argument(scope, node)
            if path.partition(".")[0] != name or not keys:
                continue
            source = f"json.dumps({_dict_source(keys)})" + (".encode()" if is_bytes or "." in path else "")
            attribute, fields = path.partition(".")[2], _known(keys)
            if attribute:
                topic = self._topic_of(scope, name)
                fields = (topic, *(field for field in fields if field.name != "topic")) if topic is not None else fields
                named = "topic=m.topic, " if topic is not None else "topic='', "
                source = f"SimpleNamespace({named}{attribute.partition('.')[0]}={source})"
            return _Argument(source, fields)
        return None

    def _keys_of_argument(self, scope: Scope, node: ast.Call) -> list[tuple[str, MessageField]]:
        """Of a value that is handed on at once, `self.handle(json.loads(line))`, the keys that are read there."""
        call = self._flow.parents.get(id(node))
        targets = self._flow.methods.get(last_name(call.func), []) if isinstance(call, ast.Call) else []
        if not isinstance(call, ast.Call) or node not in call.args or len(targets) != 1:
            return []
        function = targets[0].node
        assert not isinstance(function, ast.ClassDef)
        names = _names_given(function)
        index = call.args.index(node)
        return self._keys(targets[0], names[index], 1) if index < len(names) else []

    def _topic_of(self, scope: Scope, name: str) -> MessageField | None:
        """The topics with which a callback of a client of MQTT compares its message's; None where it does not."""
        found: dict[str, MessageField] = {}
        for node in ast.walk(scope.node):
            if isinstance(node, ast.Attribute) and node.attr == "topic" and name_with_dots(node.value) == name:
                self._add_key(found, "topic", self._fields.read_value(node, scope, "topic"))
        topic = found.get("topic")
        return topic if topic is not None and topic.values else None

    def _keys(self, scope: Scope, name: str, depth: int = 0) -> list[tuple[str, MessageField]]:
        """The keys of a dict that a function reads, and those do to which it hands it, each with its values."""
        found: dict[str, MessageField] = {}
        for node in ast.walk(scope.node):
            if not isinstance(node, ast.expr):
                continue
            key, default = _key_of(node, name)
            if key is not None:
                self._add_key(found, key, self._read_key(scope, node, key, default))
            if isinstance(node, ast.Call) and depth < MAX_HANDOVERS:
                for target, parameter in self._handovers(scope, node, name):
                    for inner, field in self._keys(target, parameter, depth + 1):
                        self._add_key(found, inner, field)
        return _with_own_names(found)

    def _handovers(self, scope: Scope, node: ast.Call, name: str) -> Iterator[tuple[Scope, str]]:
        """The functions of the code that get a value of this name, and the name that it has there."""
        targets = self._flow.methods.get(last_name(node.func), [])
        if not any(name_with_dots(argument) == name for argument in node.args) or len(targets) != 1:
            return
        function = targets[0].node
        assert not isinstance(function, ast.ClassDef)
        names = _names_given(function)
        if targets[0].node is not scope.node:
            yield from ((targets[0], parameter) for argument, parameter in zip(node.args, names, strict=False)
                        if name_with_dots(argument) == name)  # fmt: skip

    def _read_key(self, scope: Scope, node: ast.expr, key: str, default: object) -> MessageField:
        read = self._fields.read_value(node, scope, word(key))
        passed = self._usage.keys.get(key, [])
        known = [*passed, *([default] if default is not None else [])]
        is_whole = bool(known) and all(type(value) is int for value in known)
        return _with_constants(replace(read, kind=_kind_of(known, read), type="int" if is_whole else ""), passed)

    def _add_key(self, found: dict[str, MessageField], key: str, field: MessageField) -> None:
        before = found.get(key)
        if before is not None:
            values = {value.text: value for value in (*before.values, *field.values)}
            kind = "str" if values else before.kind or field.kind
            compared = tuple(dict.fromkeys((*before.compared, *field.compared)))
            field = replace(field, kind=kind, values=tuple(values.values()), compared=compared if not values else ())
        found[key] = field


def _key_of(node: ast.expr, name: str) -> tuple[str | None, object]:
    """The key of the dict of a name that an expression reads, and the default for it."""
    key: object = None
    default: object = None
    if isinstance(node, ast.Subscript) and name_with_dots(node.value) == name and isinstance(node.ctx, ast.Load):
        key = getattr(node.slice, "value", None)
    elif isinstance(node, ast.Call) and name_with_dots(node.func) == f"{name}.get" and node.args:
        key = getattr(node.args[0], "value", None)
        default = getattr(node.args[1], "value", None) if len(node.args) > 1 else None
    return (key if isinstance(key, str) else None), default


def _dict_source(keys: list[tuple[str, MessageField]]) -> str:
    """The expression of a dict; what nothing is known of has a neutral value."""
    pairs = (f"{key!r}: {f'm.{field.name}' if field.kind else 'Anything()'}" for key, field in keys)
    return "{" + ", ".join(pairs) + "}"


def _names_given(function: Function) -> list[str]:
    """The parameters that a call fills, without `self`."""
    names = [part.arg for part in parameters_of(function)]
    return names[1:] if names[:1] in (["self"], ["cls"]) else names


def _with_own_names(found: dict[str, MessageField]) -> list[tuple[str, MessageField]]:
    """Keys with their fields, each of which has a name of its own."""
    names: set[str] = set()
    made = []
    for key, field in found.items():
        name = field.name
        while name in names:
            name += "_"
        names.add(name)
        made.append((key, replace(field, name=name)))
    return made


def _known(keys: list[tuple[str, MessageField]]) -> tuple[MessageField, ...]:
    return tuple(field for _, field in keys if field.kind)


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


def _kind_of(values: list[object], field: MessageField) -> str:
    """The kind of a parameter that the code does not annotate, by what programs pass and what it compares with."""
    if field.values:
        return "str"
    if field.compared:
        return "float"
    for kind, name in ((bool, "bool"), (str, "str"), (int, "float"), (float, "float")):
        if values and all(isinstance(value, kind) for value in values):
            return name
    return ""


def _with_constants(field: MessageField, constants: list[object]) -> MessageField:
    """A field with the texts that programs pass."""
    if field.kind != "str" or field.by_type:
        return field
    there = {value.text for value in field.values}
    texts = dict.fromkeys(text for text in constants if isinstance(text, str) and text and text not in there)
    more = tuple(FieldValue(text, field.location) for text in list(texts)[:8])
    return replace(field, values=(*field.values, *more))
