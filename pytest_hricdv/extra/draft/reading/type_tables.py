"""Functions that handle messages of one class each: tables from a class to a function, and single dispatch.

`{Order: self.on_order}`, of which `type(message)` looks one up, and `@handle.register` of functools say what a function
is called with, where no call does.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from pytest_hricdv.extra.draft.found.findings import Place
from pytest_hricdv.extra.draft.reading.classes import form_of
from pytest_hricdv.extra.draft.reading.sources import Module, Scope, Sources, dotted_name


@dataclass(frozen=True)
class Handled:
    """A class of messages, the function that handles them, and where that is written."""

    message: Scope
    function: Scope
    place: Place


def handled(
    sources: Sources,
    nodes: Iterable[tuple[Module, Scope | None, ast.AST]],
    methods: Mapping[str, Sequence[Scope]],
) -> Iterator[Handled]:
    """All classes of messages that have a function of their own.

    Args:
        sources: of the code.
        nodes: of the code, each with the function around it.
        methods: functions and methods by name.
    """
    for module, scope, node in nodes:
        if isinstance(node, ast.Dict):
            for key, value in zip(node.keys, node.values, strict=True):
                yield from _row(sources, methods, module, scope, key, value)
    for function in sources.functions:
        yield from _registered(sources, function)


def is_single_dispatch(function: Scope) -> bool:
    """Whether functions for classes are registered with it."""
    assert not isinstance(function.node, ast.ClassDef)
    names = [dotted_name(decorator).rpartition(".")[2] for decorator in function.node.decorator_list]
    return bool({"singledispatch", "singledispatchmethod"} & {*names})


def is_first(scope: Scope, name: str) -> bool:
    """Whether a parameter is the first one but `self`."""
    assert not isinstance(scope.node, ast.ClassDef)
    names = [parameter.arg for parameter in (*scope.node.args.posonlyargs, *scope.node.args.args)]
    return names[scope.owner is not None :][:1] == [name]


def _row(
    sources: Sources,
    methods: Mapping[str, Sequence[Scope]],
    module: Module,
    scope: Scope | None,
    key: ast.expr | None,
    value: ast.expr,
) -> Iterator[Handled]:
    """A row of a table, if it leads from a class of messages to a function."""
    message = _message(sources, module, key)
    name = dotted_name(value)
    if message is None or not name:
        return
    owner = scope.owner if scope is not None and name.startswith("self.") else None
    for function in methods.get(name.rpartition(".")[2], ()):
        if function.owner is owner or (owner is None and "." in name):
            yield Handled(message, function, module.place(key) if key is not None else function.place)
            return


def _registered(sources: Sources, function: Scope) -> Iterator[Handled]:
    """What a function of single dispatch is registered for: by its decorator, or its first annotation."""
    assert not isinstance(function.node, ast.ClassDef)
    for decorator in function.node.decorator_list:
        called = decorator.func if isinstance(decorator, ast.Call) else decorator
        if not (isinstance(called, ast.Attribute) and called.attr == "register"):
            continue
        parameters = [*function.node.args.posonlyargs, *function.node.args.args][function.owner is not None :]
        named = decorator.args[0] if isinstance(decorator, ast.Call) and decorator.args else None
        for parameter in parameters[:1]:
            message = _message(sources, function.module, named or parameter.annotation)
            if message is not None:
                yield Handled(message, function, function.place)


def _message(sources: Sources, module: Module, expression: ast.expr | None) -> Scope | None:
    own = sources.class_of(module, expression)
    return own if own is not None and form_of(sources, own) not in ("", "enum") else None
