"""Keys of dicts without a class, as fields of a message."""

from __future__ import annotations

import ast
from dataclasses import replace

from pytest_hricdv.extra.draft.code.sources import name_with_dots
from pytest_hricdv.extra.draft.code_model import MessageField


def key_of(node: ast.expr, name: str) -> tuple[str | None, object]:
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


def dict_source(keys: list[tuple[str, MessageField]]) -> str:
    """The source of a dict; a key of unknown kind gets a neutral value."""
    pairs = [f"{key!r}: {f'm.{field.name}' if field.kind else 'Neutral()'}" for key, field in keys]
    return "{" + ", ".join(pairs) + "}"


def with_unique_names(fields: dict[str, MessageField]) -> list[tuple[str, MessageField]]:
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


def fields_of_keys(keys: list[tuple[str, MessageField]]) -> tuple[MessageField, ...]:
    """The fields whose kind is known."""
    return tuple(field for _, field in keys if field.kind)
