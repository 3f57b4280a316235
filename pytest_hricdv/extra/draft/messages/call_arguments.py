"""What a function of the code is called with: source text of its arguments, made of the fields of a message."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, replace

from pytest_hricdv.extra.draft.found.findings import FoundValue, MessageField
from pytest_hricdv.extra.draft.messages.connections import RECEIVES, SENDS, sent
from pytest_hricdv.extra.draft.messages.plain_reader import PlainReader
from pytest_hricdv.extra.draft.messages.plain_value import PlainValue
from pytest_hricdv.extra.draft.reading.constants import is_enum, members
from pytest_hricdv.extra.draft.reading.naming import unit_of, word
from pytest_hricdv.extra.draft.reading.neutral import neutral
from pytest_hricdv.extra.draft.reading.sources import Function, Scope, Sources, dotted_name
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow, default_of, parameter_names

TYPES = {"str": "str", "float": "float", "bool": "bool"}
DEFAULTS = {"str": '""', "float": "0.0", "bool": "False"}
_WRITTEN = {"str": "str", "int": "int", "float": "float", "bool": "bool", "bytes": "bytes"}


@dataclass(frozen=True)
class Argument:
    """An argument.

    Args:
        source: text of its value; `message` is the message.
        fields: of the message that it is made of.
        keyword: its name, where it has to be handed over by it.
        needs: names in the source, as (module, name).
    """

    source: str
    fields: tuple[MessageField, ...] = ()
    keyword: str = ""
    needs: tuple[tuple[str, str], ...] = ()


def arguments_of(sources: Sources, flow: ValueFlow, reader: PlainReader, scope: Scope) -> tuple[Argument, ...] | None:
    """The arguments of a function, without those that have a default of which nothing is known."""
    function = scope.node
    assert not isinstance(function, ast.ClassDef)
    made: list[Argument] = []
    is_left_out = False
    static = any(dotted_name(decorator) == "staticmethod" for decorator in function.decorator_list)
    names = parameter_names(function)[1 if scope.owner is not None and not static else 0 :]
    for name in names:
        has_default = default_of(function, name) is not None
        argument = _argument(sources, reader, scope, function, name)
        if has_default and not argument.fields:
            is_left_out = True
            continue
        is_keyword = is_left_out or any(part.arg == name for part in function.args.kwonlyargs)
        made.append(replace(argument, keyword=name) if is_keyword else argument)
    made += _of_request(flow, reader, scope, function)
    return tuple(made)


def _argument(sources: Sources, reader: PlainReader, scope: Scope, function: Function, name: str) -> Argument:
    part = next(p for p in (*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs)
                if p.arg == name)  # fmt: skip
    place = scope.module.place(part)
    own = sources.class_of(scope.module, part.annotation)
    if own is not None and is_enum(sources, own):
        values = tuple(FoundValue(m.text, own.module.place(at)) for m, at in members(sources, own))
        named = MessageField(word(name), "str", "str", place, values, default='""')
        source = f"next(member for member in {own.node.name} if text_of(member) == message.{named.name})"
        return Argument(source, (named,), needs=((own.module.name, own.node.name),))
    talk = _talk(reader, scope, name)
    if talk is not None:
        fields: list[MessageField] = []
        return Argument(f"TALK({_source(talk, word(name), '', fields)})", tuple(fields))
    value = PlainValue(place)
    reader.read_name(name, scope, value)
    written = _WRITTEN.get(ast.unparse(part.annotation).strip("'\"") if part.annotation is not None else "", "")
    value.finish()
    if not (value.is_known or value.attributes or written):
        made = neutral(sources, scope.module, part.annotation)
        if made is not None:
            return Argument(made[0], needs=made[1])
        return Argument("Anything()" if value.is_object else _unknown(name))
    fields = []
    source = _source(value, word(name), written, fields)
    return Argument(source, tuple(fields))


def _talk(reader: PlainReader, scope: Scope, name: str) -> PlainValue | None:
    """What comes by a connection that a function is called with; None where its argument is none."""
    value, is_read = PlainValue(scope.place), False
    for node in ast.walk(scope.node):
        func = node.func if isinstance(node, ast.Call) else None
        if isinstance(func, ast.Attribute) and dotted_name(func.value) == name and func.attr in RECEIVES:
            is_read = True
            reader.read(node, scope.module, scope, value)
        elif isinstance(node, ast.AsyncFor) and dotted_name(node.iter) == name and isinstance(node.target, ast.Name):
            is_read = True
            reader.read_name(node.target.id, scope, value)
    return value.finish() if is_read else None


def sent_by(scope: Scope, name: str) -> Iterator[ast.expr]:
    """What a function sends by a connection that it is called with."""
    for node in ast.walk(scope.node):
        func = node.func if isinstance(node, ast.Call) else None
        if isinstance(node, ast.Call) and isinstance(func, ast.Attribute) and func.attr in SENDS:
            content = sent(node, func.attr)
            if dotted_name(func.value) == name and content is not None:
                yield content


def _unknown(name: str) -> str:
    """Of an argument of which nothing is read: a number where its name has a unit."""
    return "0.0" if unit_of(name) else "None"


def _source(value: PlainValue, name: str, written: str, fields: list[MessageField], depth: int = 0) -> str:
    """Source text of a value; adds the fields that it is made of."""

    def inner(step: str, content: PlainValue) -> str:
        part = word(step) if depth == 0 and not value.attributes else f"{name}_{word(step)}"
        taken = {field.name for field in fields}
        return _source(content, part if part not in taken else f"{name}_{word(step)}", "", fields, depth + 1)

    if value.attributes and not value.keys and depth < 3:
        parts = ", ".join(f"{step}={inner(step, content)}" for step, content in value.attributes.items())
        return f"SimpleNamespace({parts})"
    if value.keys and depth < 4:
        pairs = ", ".join(f'"{step}": {inner(step, content)}' for step, content in value.keys.items())
        source = f"{{{pairs}}}"
        source = f"json.dumps({source})" if value.is_json else source
    elif value.items and not value.texts and depth < 4:
        count = max(value.items) + 1
        items = [inner(value.names.get(n, "") or f"item_{n}", value.items[n]) if n in value.items else "None"
                 for n in range(count)]  # fmt: skip
        return f"({', '.join(items)},)"
    else:
        source = _leaf(value, name, written, fields)
    return f"{source}.encode()" if value.is_bytes or written == "bytes" else source


def _leaf(value: PlainValue, name: str, written: str, fields: list[MessageField]) -> str:
    kind = {"int": "float", "bytes": "str"}.get(written, written) or value.kind
    values = tuple(FoundValue(text, place) for text, place in value.texts.items()) if kind == "str" else ()
    unit = unit_of(name) if kind == "float" else ""
    numbers = tuple(value.numbers) if kind == "float" else ()
    if all(field.name != name for field in fields):
        type_, default = ("int", "0") if written == "int" else (TYPES[kind], DEFAULTS[kind])
        fields.append(MessageField(name, type_, kind, value.place, values, unit, default, compared=numbers))
    if kind == "float" and value.is_number and (value.is_bytes or value.is_text):
        return f"str(message.{name})"  # a number as a text
    return f"message.{name}"


def _of_request(flow: ValueFlow, reader: PlainReader, scope: Scope, function: Function) -> list[Argument]:
    """What a function of a web framework reads of its request: `request.get_json()`, `request.form["name"]`."""
    if "request" not in scope.module.imports or "request" in parameter_names(function):
        return []
    value = PlainValue(scope.place)
    for node in ast.walk(function):
        if isinstance(node, ast.Attribute) and dotted_name(node.value) == "request":
            used: ast.AST = node
            parent = reader.parent(node)
            if node.attr == "get_json" and isinstance(parent, ast.Call):
                used = parent
            if node.attr in ("get_json", "json", "form", "args", "values"):
                reader.read(used, scope.module, scope, value)
    if not value.keys:
        return []
    fields: list[MessageField] = []
    source = _source(replace(value, is_json=False, attributes={}), "request", "", fields)
    return [Argument(source, tuple(fields), "request")]
