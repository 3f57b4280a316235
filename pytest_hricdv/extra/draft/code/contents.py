"""Infers the fields of values without a class from how the code under test reads them.

Such a value is a dict, JSON, a tuple, a text that the code splits, or an object whose attributes it reads. The result
of `ContentReader` is an `Argument`: fields for a drafted message, and an expression that makes the value from one.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from pytest_hricdv.extra.draft.code.fields import FieldReader, merge_fields
from pytest_hricdv.extra.draft.code.flow import SAME, Flow, last_name
from pytest_hricdv.extra.draft.code.naming import word
from pytest_hricdv.extra.draft.code.sources import Scope, name_with_dots
from pytest_hricdv.extra.draft.code.uses import Branches, kind_of_use, walk_what_runs
from pytest_hricdv.extra.draft.code_model import FieldValue, Imports, MessageField

_KINDS = {bool: "bool", str: "str", int: "float", float: "float"}
"""Type of the default of a key -> kind of its values."""

MAX_CALLS = 2
"""Number of nested calls through which a dict is followed."""


@dataclass(frozen=True)
class Argument:
    """An expression (`source`) that makes a value from the fields of a message `m`, with these fields."""

    source: str
    fields: tuple[MessageField, ...] = ()
    imports: Imports = ()

    def fix(self, name: str, text: str) -> Argument:
        """The argument with one field replaced by a constant text."""
        source = re.sub(rf"\bm\.{name}\b", lambda _: repr(text), self.source)
        return Argument(source, tuple(part for part in self.fields if part.name != name), self.imports)


class ContentReader:
    """Infers the fields of values from the functions that use them.

    If a function branches on a field (`if message["kind"] == "stop"`) and reads different fields in each branch, the
    value has a *variant* for each text of this field.
    """

    def __init__(self, flow: Flow, fields: FieldReader) -> None:
        self._flow, self._fields = flow, fields
        self._skipped: frozenset[int] = frozenset()
        self._places: dict[str, list[tuple[Scope, ast.AST]]] = {}

    def variants_of_result(self, scope: Scope, node: ast.Call | ast.AsyncFor) -> list[tuple[str, Argument]]:
        """The variants of the result of a call, by the names that it is assigned to; like `variants`."""
        parent = self._flow.parents.get(id(node))
        parent = self._flow.parents.get(id(parent)) if isinstance(parent, ast.Await) else parent
        if isinstance(parent, ast.Assign) and isinstance(parent.targets[0], ast.Tuple):
            variants = self._variants_of(lambda: self._unpack(scope, parent.targets[0], None))
            decides = len(variants) > 1 or any(part.values for _, argument in variants for part in argument.fields)
            return variants if decides else []  # such as the bytes and the sender of a datagram
        for name in self._names_of(node):
            if variants := self.variants(scope, name):
                return variants
            text = self._fields.parameter(scope, name, None)
            if text.values:
                return [("", Argument(f"m.{text.name}", (text,)))]
        return []

    def variants(self, scope: Scope, name: str) -> list[tuple[str, Argument]]:
        """The variants of a named value in a function, each with its text; a single variant has an empty string."""
        return self._variants_of(lambda: self.of_name(scope, name))

    def _variants_of(self, read: Callable[[], Argument | None]) -> list[tuple[str, Argument]]:
        self._places.clear()
        whole = read()
        if whole is None:
            return []
        for part in whole.fields:
            branches = Branches(self._flow, list(self._places.get(part.name, ())))
            if len(part.values) < 2 or part.name not in self._places:
                continue
            variants = []
            for value in part.values:
                self._skipped = branches.find_skips(value.text)
                argument = read()
                self._skipped = frozenset()
                if argument is not None and any(field.name == part.name for field in argument.fields):
                    variants.append((value.text, argument.fix(part.name, value.text)))
            if len({tuple(field.name for field in argument.fields) for _, argument in variants}) > 1:
                return variants
        return [("", whole)]

    def _names_of(self, node: ast.AST) -> Iterator[str]:
        """The names that a value is assigned to, also through `json.loads`, or that a loop gives to its items."""
        if isinstance(node, ast.AsyncFor) and isinstance(node.target, ast.Name):
            yield node.target.id
            return
        parent = self._flow.parents.get(id(node))
        while isinstance(parent, ast.Await | ast.Call | ast.Attribute):
            parent = self._flow.parents.get(id(parent))
        targets = parent.targets if isinstance(parent, ast.Assign) else []
        yield from (target.id for target in targets if isinstance(target, ast.Name))
        if isinstance(parent, ast.AnnAssign | ast.NamedExpr) and isinstance(parent.target, ast.Name):
            yield parent.target.id

    def of_name(self, scope: Scope, name: str, depth: int = 0) -> Argument | None:
        """The value of a name, as a dict, JSON, a text or tuple, or an object: the first that fits its uses."""
        keys = self._keys(scope, name)
        if keys:
            return Argument(_dict_source(keys), _fields_of_keys(keys))
        made = self._json(scope, name) or self._parts(scope, name) or self._attributes(scope, name)
        for node in walk_what_runs(scope.node, self._skipped) if depth < MAX_CALLS else ():
            for target, parameter in self._parameters_for(scope, node, name) if isinstance(node, ast.Call) else ():
                made = made or self.of_name(target, parameter, depth + 1)
        return made

    def _json(self, scope: Scope, name: str) -> Argument | None:
        for node in walk_what_runs(scope.node, self._skipped):
            if not isinstance(node, ast.Call) or not node.args or last_name(node.func) != "loads":
                continue
            ways = [way for way, _, at in self._flow.expressions(node.args[-1], scope.module, scope) if at is scope]
            inner = next((way for way in ways if name in map(name_with_dots, ast.walk(way))), node.args[-1])
            is_bytes = "decode" in ast.unparse(inner)
            path = ast.unparse(inner).removesuffix(".decode()").partition(".decode(")[0]
            keys = [key for target in self._names_of(node) for key in self._keys(scope, target)]
            if path.partition(".")[0] != name or not keys:
                continue
            source = f"json.dumps({_dict_source(keys)})" + (".encode()" if is_bytes or "." in path else "")
            attribute, fields = path.partition(".")[2], _fields_of_keys(keys)
            if attribute:
                topic = self._topic_of(scope, name)
                fields = (topic, *(field for field in fields if field.name != "topic")) if topic is not None else fields
                named = "topic=m.topic, " if topic is not None else "topic='', "
                source = f"Neutral({named}{attribute.partition('.')[0]}={source})"
            return Argument(source, fields)
        return None

    def _parts(self, scope: Scope, name: str) -> Argument | None:
        """The names into which a function unpacks a tuple or a text: `verb, rest = line.split(" ", 1)`."""
        for node in walk_what_runs(scope.node, self._skipped):
            if not isinstance(node, ast.Assign) or not isinstance(node.targets[0], ast.Tuple):
                continue
            value, separator = node.value, None
            if isinstance(value, ast.Call) and last_name(value.func) in ("split", "partition"):
                first = value.args[0] if value.args else None
                separator = first.value if isinstance(first, ast.Constant) else " "
                value = value.func.value if isinstance(value.func, ast.Attribute) else value
                while isinstance(value, ast.Call) and isinstance(value.func, ast.Attribute) and value.func.attr in SAME:
                    value = value.func.value
            if name_with_dots(value) != name or not isinstance(separator, str | None):
                continue
            return self._unpack(scope, node.targets[0], separator)
        return None

    def _unpack(self, scope: Scope, target: ast.expr, separator: str | None) -> Argument | None:
        parts = target.elts if isinstance(target, ast.Tuple) else []
        parts = [part.value if isinstance(part, ast.Starred) else part for part in parts]
        names = [part.id for part in parts if isinstance(part, ast.Name)]
        if len(names) != len(parts):
            return None
        return self._join(scope, [name for name in names if name.strip("_")], separator)

    def _join(self, scope: Scope, names: list[str], separator: str | None) -> Argument:
        fields = []
        for name in names:
            part = self._fields.parameter(scope, name, None)
            for node in walk_what_runs(scope.node, self._skipped):
                if isinstance(node, ast.Name) and node.id == name and isinstance(node.ctx, ast.Load):
                    self._note(word(name), scope, node)
                    above = self._flow.parents.get(id(node))
                    if isinstance(above, ast.Subscript) and above.value is node:  # one of several words
                        word_of = self._fields.read_value(above, scope, name)
                        values = {value.text: value for value in (*part.values, *word_of.values)}
                        part = replace(part, kind=part.kind or word_of.kind, values=tuple(values.values()))
            fields.append(replace(part, name=word(name)))
        known = tuple(part for part in fields if part.kind)
        if separator is None:
            texts = [f"m.{part.name}" if part.kind else "Neutral()" for part in fields]
            return Argument(f"({', '.join(texts)},)", known)
        texts = [f"str(m.{part.name})" if part.kind != "str" else f"m.{part.name}" for part in known]
        return Argument(f" + {separator!r} + ".join(texts), known)

    def _attributes(self, scope: Scope, name: str) -> Argument | None:
        """An object whose attributes a function compares or converts to numbers."""
        fields: dict[str, MessageField] = {}
        sources: dict[str, str] = {}
        for node in walk_what_runs(scope.node, self._skipped):
            if isinstance(node, ast.Attribute) and name_with_dots(node.value) == name:
                field = self._fields.read_value(node, scope, word(node.attr))
                top, is_bytes = self._text_of_bytes(node)
                if not field.kind and is_bytes and kind_of_use(self._flow, top) == "float":
                    sources[node.attr] = "str({}).encode()"
                    field = replace(field, kind="float", type="int")  # a text that is a whole number is any number
                elif is_bytes and field.kind == "str":
                    sources[node.attr] = "{}.encode()"
                if field.kind:
                    self._note(word(node.attr), scope, node)
                    fields[node.attr] = merge_fields(fields.get(node.attr), field)
        if not fields:
            return None
        pairs = _with_unique_names(fields)
        arguments = ", ".join(f"{key}={sources.get(key, '{}').format(f'm.{field.name}')}" for key, field in pairs)
        return Argument(f"Neutral({arguments})", tuple(field for _, field in pairs))

    def _text_of_bytes(self, node: ast.expr) -> tuple[ast.expr, bool]:
        """The expression with its text methods, and whether the value is bytes: decoded, or compared with bytes."""
        above = self._flow.parents.get(id(node))
        if isinstance(above, ast.Compare):
            return node, any(isinstance(getattr(other, "value", None), bytes) for other in above.comparators)
        is_bytes = False
        while isinstance(above, ast.Attribute) and above.attr in SAME:
            is_bytes |= above.attr == "decode"
            called = self._flow.parents.get(id(above))
            node = called if isinstance(called, ast.Call) else above
            above = self._flow.parents.get(id(node))
        return node, is_bytes

    def _topic_of(self, scope: Scope, name: str) -> MessageField | None:
        """The topics with which an MQTT callback compares the topic of its message; None without a comparison."""
        fields: dict[str, MessageField] = {}
        for node in walk_what_runs(scope.node, self._skipped):
            if isinstance(node, ast.Attribute) and node.attr == "topic" and name_with_dots(node.value) == name:
                self._note("topic", scope, node)
                fields["topic"] = merge_fields(fields.get("topic"), self._fields.read_value(node, scope, "topic"))
        topic = fields.get("topic")
        return topic if topic is not None and topic.values else None

    def _keys(self, scope: Scope, name: str, depth: int = 0) -> list[tuple[str, MessageField]]:
        """The keys of a dict that a function reads, also in functions that it passes the dict to, with their fields."""
        fields: dict[str, MessageField] = {}
        for node in walk_what_runs(scope.node, self._skipped):
            if not isinstance(node, ast.expr):
                continue
            key, default = _key_of(node, name)
            if key is not None:
                self._note(word(key), scope, node)
                fields[key] = merge_fields(fields.get(key), self._read_key(scope, node, key, default))
            if isinstance(node, ast.Call) and depth < MAX_CALLS:
                for target, parameter in self._parameters_for(scope, node, name):
                    for inner, field in self._keys(target, parameter, depth + 1):
                        fields[inner] = merge_fields(fields.get(inner), field)
        return _with_unique_names(fields)

    def _note(self, field: str, scope: Scope, node: ast.AST) -> None:
        if not self._skipped:
            self._places.setdefault(field, []).append((scope, node))

    def _parameters_for(self, scope: Scope, node: ast.Call, name: str) -> Iterator[tuple[Scope, str]]:
        """The functions that a call passes the name to, each with its parameter."""
        passed = [pair for argument in (*node.args, *(keyword.value for keyword in node.keywords))
                  if name_with_dots(argument) == name for pair in self._flow.receivers(node, argument)]  # fmt: skip
        if len({id(target.node) for target, _ in passed} - {id(scope.node)}) == len(passed) == 1:
            yield passed[0]

    def _read_key(self, scope: Scope, node: ast.expr, key: str, default: object) -> MessageField:
        read = self._fields.read_value(node, scope, word(key))
        kind = read.kind or _KINDS.get(type(default), "") or kind_of_use(self._flow, node)
        values = {value.text: value for value in read.values}
        if isinstance(default, str) and default and kind == "str":
            values.setdefault(default, FieldValue(default, read.location))
        return replace(read, kind=kind, type="int" if type(default) is int else "", values=tuple(values.values()))


def _key_of(node: ast.expr, name: str) -> tuple[str | None, object]:
    """The key that an expression reads from the dict of a name, and the default; None if it reads none."""
    key: object = None
    default: object = None
    owner: ast.expr | None = None
    if isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Load):
        owner, key = node.value, getattr(node.slice, "value", None)
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "get" and node.args:
        owner, key = node.func.value, getattr(node.args[0], "value", None)
        default = getattr(node.args[1], "value", None) if len(node.args) > 1 else None
    return (key, default) if isinstance(key, str) and name_with_dots(owner) == name else (None, None)


def _dict_source(keys: list[tuple[str, MessageField]]) -> str:
    """The source of a dict; a key of unknown kind gets a neutral value."""
    pairs = [f"{key!r}: {f'm.{field.name}' if field.kind else 'Neutral()'}" for key, field in keys]
    return "{" + ", ".join(pairs) + "}"


def _with_unique_names(fields: dict[str, MessageField]) -> list[tuple[str, MessageField]]:
    """The keys with their fields, whose names are made unique."""
    names: set[str] = set()
    pairs = []
    for key, field in fields.items():
        name = field.name
        while name in names:
            name += "_"
        names.add(name)
        pairs.append((key, replace(field, name=name)))
    return pairs


def _fields_of_keys(keys: list[tuple[str, MessageField]]) -> tuple[MessageField, ...]:
    """The fields whose kind is known."""
    return tuple(field for _, field in keys if field.kind)
