"""Of which class of the code an expression is an instance, as far as annotations and calls say it."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.extra.draft.reading.sources import Module, Scope, Sources
from pytest_hricdv.extra.draft.reading.type_tables import Handled, is_first

MAX_CALLS = 4
"""Calls that hand an instance on, between where it is made and where it is used (chosen)."""


@dataclass(frozen=True)
class Instances:
    """Finds the classes of expressions.

    Args:
        sources: of the code.
        methods: functions and methods by name.
        arguments: what a parameter of a function is called with, each with where that is written.
        handlers: functions that handle messages of one class each, by the identity of their nodes.
        attributes: what methods assign to attributes of `self`: (class, by identity, attribute) -> where, and what.
    """

    sources: Sources
    methods: Mapping[str, Sequence[Scope]]
    arguments: Callable[[Scope, str], Iterable[tuple[Any, Module, Scope | None]]]
    handlers: Mapping[int, Handled]
    attributes: Mapping[tuple[int, str], Sequence[tuple[Scope, ast.expr]]]

    def class_of(
        self, expression: ast.expr, module: Module, scope: Scope | None, calls: int = 0
    ) -> ast.ClassDef | None:
        """The class of `self`, of what makes one, of an attribute, or of a parameter; None where it is not known.

        A parameter without an annotation has that of the same method of a base class; else the class of what all calls
        hand over, as far as it is known of them. So has an attribute of what is assigned to it.
        """
        if isinstance(expression, ast.Call):
            return self._named(module, expression.func)
        if isinstance(expression, ast.BoolOp):  # `arm or Arm()`
            return self._only((value, module, scope) for value in expression.values)
        if isinstance(expression, ast.Attribute) and calls <= MAX_CALLS:
            owner = self.class_of(expression.value, module, scope, calls + 1)
            values = self.attributes.get((id(owner), expression.attr), ())
            return self._only(((value, at.module, at) for at, value in values), calls + 1)
        if scope is None or not isinstance(expression, ast.Name) or isinstance(scope.node, ast.ClassDef):
            return None
        if expression.id == "self":
            return scope.owner
        parameter = _parameter(scope, expression.id)
        if parameter is None or calls > MAX_CALLS:
            return None
        if parameter.annotation is not None:
            return self._named(module, parameter.annotation)
        row = self.handlers.get(id(scope.node))
        if row is not None and is_first(scope, expression.id):
            return row.message.node if isinstance(row.message.node, ast.ClassDef) else None
        inherited = self._annotated_in_base(scope, expression.id)
        if inherited is not None:
            return inherited
        return self._only(self.arguments(scope, expression.id), calls + 1)

    def _only(self, values: Iterable[tuple[Any, Module, Scope | None]], calls: int = 0) -> ast.ClassDef | None:
        """The class of all values of which it is known; None where they are of several."""
        classes = [self.class_of(value, where, at, calls) for value, where, at in values]
        made_of = {id(node): node for node in classes if node is not None}
        return next(iter(made_of.values())) if len(made_of) == 1 else None

    def _named(self, module: Module, expression: ast.expr | None) -> ast.ClassDef | None:
        own = self.sources.class_of(module, expression)
        return own.node if own is not None and isinstance(own.node, ast.ClassDef) else None

    def _annotated_in_base(self, scope: Scope, name: str) -> ast.ClassDef | None:
        """The class that a base says of the parameter of a method that is overridden."""
        if scope.owner is None or isinstance(scope.node, ast.ClassDef):
            return None
        bases = self.sources.base_classes(Scope(scope.module, scope.owner))
        for method in self.methods.get(scope.node.name, ()):
            if any(method.owner is base.node for base in bases):
                parameter = _parameter(method, name)
                own = self._named(method.module, parameter.annotation) if parameter is not None else None
                if own is not None:
                    return own
        return None


def _parameter(scope: Scope, name: str) -> ast.arg | None:
    assert not isinstance(scope.node, ast.ClassDef)
    arguments = scope.node.args
    parameters = (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)
    return next((parameter for parameter in parameters if parameter.arg == name), None)
