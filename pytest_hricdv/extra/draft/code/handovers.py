"""Finds callbacks, functions that the code passes to others: stimuli of the code, or handlers of connections."""

from __future__ import annotations

import ast
import builtins
import re
from collections.abc import Collection, Iterator

from pytest_hricdv.extra.draft.code.flow import Flow, last_name, parameters_of, texts
from pytest_hricdv.extra.draft.code.sources import Module, Scope, Sources, name_with_dots, resolve_import

MAX_CALLS = 2
"""Calls through which a connection is followed."""

WORKERS = {"threading", "asyncio", "concurrent", "multiprocessing", "sched", "functools", "atexit", "transitions",
           "statemachine", "py_trees", "weakref", "signal", *dir(builtins)}  # fmt: skip
"""Modules and functions that run what they are passed, whatever happens outside: it is no callback."""


class Handovers:
    """Finds where methods and functions are passed to other objects."""

    def __init__(self, sources: Sources, flow: Flow) -> None:
        self._sources, self._flow = sources, flow

    def title(self, function: Scope, owners: Collection[int] = ()) -> str:
        """The name of a function, or of an object's method, where it is passed to another object; empty if it never is.

        Args:
            owners: identities of the classes of the object.
        """
        name = function.node.name
        for module, scope, node in self._flow.nodes:
            if not isinstance(node, ast.Attribute | ast.Name) or last_name(node) != name:
                continue
            if function.owner is not None:
                is_own = scope is not None and id(scope.owner) in owners and name_with_dots(node) == f"self.{name}"
            else:
                defined = self._sources.definition(module, name_with_dots(node))
                is_own = defined is not None and defined[1] is function.node
            title = next(self._titles(module, scope, node, function), "") if is_own else ""
            if title:
                return title
        return ""

    def _titles(self, module: Module, scope: Scope | None, node: ast.AST, method: Scope) -> Iterator[str]:
        parent = self._flow.parents.get(id(node))
        assert not isinstance(method.node, ast.ClassDef)
        own, takes = method.node.name, len(parameters_of(method.node)) > (method.owner is not None)
        if isinstance(parent, ast.keyword):
            call = self._flow.parents.get(id(parent))
            yield from self._call_names(module, scope, call, own, takes, parent.arg or "")
        elif isinstance(parent, ast.Call) and parent.func is not node:
            yield from self._call_names(module, scope, parent, own, takes)
        elif isinstance(parent, ast.Assign):
            for target in parent.targets:
                if isinstance(target, ast.Attribute) and name_with_dots(target.value) != "self":
                    yield target.attr

    def _call_names(
        self, module: Module, scope: Scope | None, call: ast.AST | None, own: str, takes: bool, keyword: str = ""
    ) -> Iterator[str]:
        """Names for an argument of a call: the text next to it, or the name of the call or the parameter."""
        if not isinstance(call, ast.Call) or self._is_worker(module, scope, call):
            return
        called = last_name(call.func)
        if not takes and called in self._flow.methods:
            return  # such as a function that tries another one again
        parts = [*call.args, *(keyword.value for keyword in call.keywords)]
        texts = [text for part in parts for text in self._texts(module, scope, part)]
        if not texts and any(self._sources.class_of(module, part) is not None for part in parts):
            return  # it subscribes to a class
        named = next((name for name in (keyword, called) if name.startswith(("on_", "set_", "when_"))), "")
        yield last_part(texts[0]) if texts else named.removeprefix("on_").removeprefix("set_") or own

    def _is_worker(self, module: Module, scope: Scope | None, call: ast.Call) -> bool:
        """Whether the function that is called, or what made the object that has it, only calls what it gets."""
        receiver = call.func.value if isinstance(call.func, ast.Attribute) else None
        made = [(where, node.func) for node, where, _ in self._flow.expressions(receiver, module, scope)
                if isinstance(node, ast.Call)]  # fmt: skip
        return any(resolve_import(where, function).partition(".")[0] in WORKERS
                   for where, function in ((module, call.func), *made))  # fmt: skip

    def _texts(self, module: Module, scope: Scope | None, node: ast.expr | None) -> list[str]:
        return list(texts(self._flow.constants(node, module, scope)))


def last_part(text: str) -> str:
    """The last word of a topic, or of a path.

    >>> last_part("ward/lift/command"), last_part("orders")
    ('command', 'orders')
    """
    return re.split(r"[/.:]", text.strip("/#+. "))[-1]


def connection_of(flow: Flow, function: Scope) -> str:
    """The first parameter of a function, if it, or one to which it is passed, reads of it; otherwise empty."""
    assert not isinstance(function.node, ast.ClassDef)
    names = [part.arg for part in parameters_of(function.node)][function.owner is not None :]
    return names[0] if names and _is_read(flow, function, names[0], MAX_CALLS) else ""


def _is_read(flow: Flow, function: Scope, name: str, calls: int) -> bool:
    node: ast.AST
    for node in ast.walk(function.node):
        if isinstance(node, ast.AsyncFor) and name_with_dots(node.iter) == name:
            return True
        if isinstance(node, ast.Await) and isinstance(node.value, ast.Call):
            owner, _, method = name_with_dots(node.value.func).rpartition(".")
            if owner == name and method.startswith("rec"):  # `recv`, `receive_text`
                return True
        if isinstance(node, ast.Call) and calls:
            passed = (pair for argument in node.args if name_with_dots(argument) == name
                      for pair in flow.receivers(node, argument))  # fmt: skip
            if any(_is_read(flow, target, parameter, calls - 1) for target, parameter in passed):
                return True
    return False
