"""How classes of the code are made: their forms (dataclasses, typed dicts, enumerations ...), bases and methods."""

from __future__ import annotations

import ast

from pytest_hricdv.extra.draft.reading.constants import is_enum
from pytest_hricdv.extra.draft.reading.sources import Scope, Sources, imported_name


def form_of(sources: Sources, scope: Scope) -> str:
    """How a class is made that can be a message; empty where it cannot."""
    node = scope.node
    assert isinstance(node, ast.ClassDef)
    for decorator in node.decorator_list:
        name = imported_name(scope.module, decorator.func if isinstance(decorator, ast.Call) else decorator)
        if name.rpartition(".")[2] == "dataclass":
            return "dataclass"
        if name in ("attr.s", "attrs.define", "attrs.frozen", "attr.define", "attr.frozen", "attr.attrs"):
            return "model"
    bases = {base.rpartition(".")[2] for base in sources.bases(scope)}
    if "NamedTuple" in bases:
        return "namedtuple"
    if "TypedDict" in bases:
        return "typeddict"
    if bases & {"BaseModel", "Struct"}:
        return "model"
    if any(form_of(sources, base) == "dataclass" for base in own_bases(sources, scope)):
        return "dataclass"
    return "enum" if is_enum(sources, scope) else ""


def own_bases(sources: Sources, scope: Scope) -> list[Scope]:
    """Its bases that are classes of the code."""
    assert isinstance(scope.node, ast.ClassDef)
    bases = [sources.class_of(scope.module, base) for base in scope.node.bases]
    return [base for base in bases if base is not None and base.node is not scope.node]


def methods_of(sources: Sources, scope: Scope) -> dict[str, Scope]:
    """The methods of a class by their names, with those of its bases in the code."""
    assert isinstance(scope.node, ast.ClassDef)
    methods: dict[str, Scope] = {}
    for base in reversed(scope.node.bases):
        own = sources.class_of(scope.module, base)
        if own is not None and own.node is not scope.node:
            methods |= methods_of(sources, own)
    for statement in scope.node.body:
        if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef):
            methods[statement.name] = Scope(scope.module, statement, scope.node)
    return methods
