"""Methods that an object hands to others, which call them later: the name under which they are known there."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Mapping

from pytest_hricdv.extra.draft.code.constants import Member
from pytest_hricdv.extra.draft.code.flow import Flow, last_name, parameters_of
from pytest_hricdv.extra.draft.code.sources import Module, Scope, Sources, name_with_dots, resolve_import

WORKERS = {"threading", "asyncio", "concurrent", "multiprocessing", "sched", "functools", "atexit", "transitions",
           "weakref", "sorted", "map", "filter", "min", "max", "any", "all", "sum", "list", "super"}  # fmt: skip
"""Modules and functions that only call what they get: to run it, no matter what happens outside."""


class Handovers:
    """Finds where methods are handed over."""

    def __init__(self, sources: Sources, flow: Flow) -> None:
        self._sources, self._flow = sources, flow

    def title(self, methods: Mapping[str, Scope], name: str) -> str:
        """The name of an object's method where it is handed over; empty if it never is.

        Args:
            methods: of the object.
            name: of the method.
        """
        owners = {id(method.owner) for method in methods.values()}
        for module, scope, node in self._flow.nodes:
            is_own = scope is not None and id(scope.owner) in owners and isinstance(node, ast.Attribute)
            if is_own and node.attr == name and name_with_dots(node.value) == "self":  # type: ignore[attr-defined]
                title = next(self._titles(module, scope, node, methods[name]), "")
                if title:
                    return title
        return ""

    def _titles(self, module: Module, scope: Scope | None, node: ast.AST, method: Scope) -> Iterator[str]:
        parent = self._flow.parents.get(id(node))
        assert not isinstance(method.node, ast.ClassDef)
        own, takes = method.node.name, len(parameters_of(method.node)) > 1
        if isinstance(parent, ast.keyword):
            call = self._flow.parents.get(id(parent))
            yield from self._of_call(module, scope, call, own, takes, parent.arg or "")
        elif isinstance(parent, ast.Call) and parent.func is not node:
            yield from self._of_call(module, scope, parent, own, takes)
        elif isinstance(parent, ast.Dict):
            at = next((number for number, value in enumerate(parent.values) if value is node), None)
            texts = self._texts(module, scope, parent.keys[at]) if at is not None else []
            if takes or not self._are_states(texts):
                yield last_part(texts[0]) if texts else own
        elif isinstance(parent, ast.Tuple | ast.List) and takes:
            texts = [text for part in parent.elts for text in self._texts(module, scope, part)]
            yield last_part(texts[0]) if texts else own
        elif isinstance(parent, ast.Assign):
            for target in parent.targets:
                if isinstance(target, ast.Attribute) and name_with_dots(target.value) != "self":
                    yield target.attr
                elif isinstance(target, ast.Subscript):
                    yield last_part("".join(self._texts(module, scope, target.slice)[:1])) or own

    def _of_call(
        self, module: Module, scope: Scope | None, call: ast.AST | None, own: str, takes: bool, keyword: str = ""
    ) -> Iterator[str]:
        """Names for an argument of a call: the text next to it, or the name of the call or the parameter."""
        if not isinstance(call, ast.Call) or resolve_import(module, call.func).partition(".")[0] in WORKERS:
            return
        called = last_name(call.func)
        if not takes and called in self._flow.methods:
            return  # such as a function that tries another one again
        parts = [*call.args, *(each.value for each in call.keywords)]
        texts = [text for part in parts for text in self._texts(module, scope, part)]
        if not texts and any(self._sources.class_of(module, part) is not None for part in parts):
            return  # it subscribes to a class
        named = next((name for name in (keyword, called) if name.startswith(("on_", "set_", "when_"))), "")
        yield last_part(texts[0]) if texts else named.removeprefix("on_").removeprefix("set_") or own

    def _texts(self, module: Module, scope: Scope | None, node: ast.expr | None) -> list[str]:
        values = self._flow.values(node, module, scope) if node is not None else []
        return [text for value in values for text in [value.text if isinstance(value, Member) else value]
                if isinstance(text, str) and text]  # fmt: skip

    def _are_states(self, texts: list[str]) -> bool:
        """Whether an attribute of an object is set to one of these texts."""
        return any(isinstance(value, ast.Constant) and value.value in texts
                   for assigned in self._flow.attributes.values() for _, value in assigned)  # fmt: skip


def last_part(text: str) -> str:
    """The last word of a topic, or of a path.

    >>> last_part("ward/lift/command"), last_part("orders")
    ('command', 'orders')
    """
    return re.split(r"[/.:]", text.strip("/#+. "))[-1]
