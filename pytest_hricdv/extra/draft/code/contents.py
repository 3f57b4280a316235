"""The keys that code reads from dicts and JSON without a class, each with the values it compares them with."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from pytest_hricdv.extra.draft.code.fields import FieldReader
from pytest_hricdv.extra.draft.code.flow import Flow, last_name, parameters_of
from pytest_hricdv.extra.draft.code.naming import word
from pytest_hricdv.extra.draft.code.sources import Function, Scope, name_with_dots
from pytest_hricdv.extra.draft.code.usage import Usage
from pytest_hricdv.extra.draft.code_model import FieldValue, Imports, MessageField

MAX_HANDOVERS = 2
"""Calls through which a dict is followed."""


@dataclass(frozen=True)
class Argument:
    """What a parameter gets: the fields of the message from which an expression makes it."""

    source: str
    fields: tuple[MessageField, ...] = ()
    imports: Imports = ()


class ContentReader:
    """Reads what functions take out of a value."""

    def __init__(self, flow: Flow, fields: FieldReader, usage: Usage) -> None:
        self._flow, self._fields, self._usage = flow, fields, usage

    def of_result(self, scope: Scope, node: ast.Call) -> Argument | None:
        """What a call returns, by what is done with it under the names that it gets."""
        arguments = (self.of_name(scope, name) for name in self._names_of(node))
        return next((argument for argument in arguments if argument is not None), None)

    def _names_of(self, node: ast.AST) -> Iterator[str]:
        """The names that get a value, also through `json.loads`."""
        parent = self._flow.parents.get(id(node))
        while isinstance(parent, ast.Await | ast.Call | ast.Attribute):
            parent = self._flow.parents.get(id(parent))
        targets = parent.targets if isinstance(parent, ast.Assign) else []
        yield from (target.id for target in targets if isinstance(target, ast.Name))
        if isinstance(parent, ast.AnnAssign | ast.NamedExpr) and isinstance(parent.target, ast.Name):
            yield parent.target.id

    def of_name(self, scope: Scope, name: str) -> Argument | None:
        """A dict whose keys the code reads, JSON of one, or an object whose attributes it reads."""
        keys = self._keys(scope, name)
        if keys:
            return Argument(_dict_source(keys), _fields_of_keys(keys))
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
            attribute, fields = path.partition(".")[2], _fields_of_keys(keys)
            if attribute:
                topic = self._topic_of(scope, name)
                fields = (topic, *(field for field in fields if field.name != "topic")) if topic is not None else fields
                named = "topic=m.topic, " if topic is not None else "topic='', "
                source = f"SimpleNamespace({named}{attribute.partition('.')[0]}={source})"
            return Argument(source, fields)
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
        return with_constants(replace(read, kind=kind_of(known, read), type="int" if is_whole else ""), passed)

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
    pairs = (f"{key!r}: {f'm.{field.name}' if field.kind else 'Neutral()'}" for key, field in keys)
    return "{" + ", ".join(pairs) + "}"


def _names_given(function: Function) -> list[str]:
    """The parameters that a call fills, without `self`."""
    names = [part.arg for part in parameters_of(function)]
    return names[1:] if names[:1] in (["self"], ["cls"]) else names


def _with_own_names(found: dict[str, MessageField]) -> list[tuple[str, MessageField]]:
    """Pairs of key and field; the names of the fields are unique."""
    names: set[str] = set()
    made = []
    for key, field in found.items():
        name = field.name
        while name in names:
            name += "_"
        names.add(name)
        made.append((key, replace(field, name=name)))
    return made


def _fields_of_keys(keys: list[tuple[str, MessageField]]) -> tuple[MessageField, ...]:
    return tuple(field for _, field in keys if field.kind)


def kind_of(values: Sequence[object], field: MessageField) -> str:
    """The kind of a parameter that the code does not annotate, by what programs pass and what it compares with."""
    if field.values:
        return "str"
    if field.compared:
        return "float"
    for kind, name in ((bool, "bool"), (str, "str"), (int, "float"), (float, "float")):
        if values and all(isinstance(value, kind) for value in values):
            return name
    return ""


def with_constants(field: MessageField, constants: Sequence[object]) -> MessageField:
    """A field with the texts that programs pass."""
    if field.kind != "str" or field.by_type:
        return field
    there = {value.text for value in field.values}
    texts = dict.fromkeys(text for text in constants if isinstance(text, str) and text and text not in there)
    more = tuple(FieldValue(text, field.location) for text in list(texts)[:8])
    return replace(field, values=(*field.values, *more))
