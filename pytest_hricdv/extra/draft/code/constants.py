"""Evaluates expressions of a module without running it: `evaluate` for constants and tables, `members` for enums."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from operator import add, mul, sub, truediv
from typing import Any

from pytest_hricdv.extra.draft.code.sources import Module, Scope, Sources, name_with_dots, resolve_import

MAX_DEPTH = 30
"""Most names that stand for each other in a row; longer chains are taken for cycles."""


class UnknownConstantError(Exception):
    """The value is not known without running the code."""


@dataclass(frozen=True)
class Reference:
    """A value that is a function or class of the code, or a name from outside."""

    name: str


@dataclass(frozen=True)
class Member:
    """A member of an enumeration; `value` is a constant where it is one."""

    enum: str
    name: str
    value: Any

    @property
    def text(self) -> str:
        """Its text in the record: its value if this is a string, else its name."""
        return self.value if isinstance(self.value, str) else self.name


_ENUMS = ("Enum", "IntEnum", "StrEnum", "Flag", "IntFlag")
_COLLECTIONS = ("tuple", "list", "set", "frozenset", "dict", "MappingProxyType", "types.MappingProxyType")


def is_enum(sources: Sources, scope: Scope) -> bool:
    """Whether a class is an enumeration."""
    return any(base.rpartition(".")[2] in _ENUMS for base in sources.bases(scope))


def members(sources: Sources, scope: Scope) -> tuple[tuple[Member, ast.stmt], ...]:
    """The members of an enumeration, with where they are defined."""
    assert isinstance(scope.node, ast.ClassDef)
    is_text = any(base.rpartition(".")[2] == "StrEnum" for base in sources.bases(scope))
    pairs = []
    for statement in scope.node.body:
        for target, value in assignments(statement) if isinstance(statement, ast.Assign) else ():
            if isinstance(target, ast.Name) and not target.id.startswith("_"):
                try:
                    content = evaluate(sources, scope.module, value)
                except UnknownConstantError:  # such as of `auto()`
                    content = target.id.lower() if is_text else None
                pairs.append((Member(scope.node.name, target.id, content), statement))
    return tuple(pairs)


def assignments(node: ast.AST) -> Iterator[tuple[ast.expr, ast.expr]]:
    """Targets and values of a statement, those of tuples one by one."""
    if isinstance(node, ast.AnnAssign | ast.NamedExpr) and node.value is not None:
        yield node.target, node.value
    for target in node.targets if isinstance(node, ast.Assign) else ():
        assert isinstance(node, ast.Assign)
        if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
            yield from zip(target.elts, node.value.elts, strict=False)
        else:
            yield target, node.value


_OPERATORS: dict[type, Any] = {ast.Add: add, ast.Sub: sub, ast.Mult: mul, ast.Div: truediv}


def evaluate(sources: Sources, module: Module, node: ast.AST | None, depth: int = 0) -> Any:
    """The value of an expression: constants, tuples (also for lists and sets), dicts, `Member`, `Reference`.

    Raises:
        UnknownConstantError: it is not known.
    """
    if depth > MAX_DEPTH:
        raise UnknownConstantError

    def inner(child: ast.AST | None) -> Any:
        return evaluate(sources, module, child, depth + 1)

    def inner_or_name(child: ast.expr) -> Any:
        """The value, or its name if it is unknown, so that the other values of a table still count."""
        try:
            return inner(child)
        except UnknownConstantError:
            return Reference(name_with_dots(child))

    match node:
        case ast.Constant():
            return node.value
        case ast.Tuple() | ast.List() | ast.Set():
            values: list[Any] = []
            for element in node.elts:
                values += inner(element.value) if isinstance(element, ast.Starred) else [inner_or_name(element)]
            return tuple(values)
        case ast.Dict():
            return _dict(node, inner, inner_or_name)
        case ast.Name() | ast.Attribute():
            return _value_of_name(sources, module, node, depth)
        case ast.Subscript():
            try:
                return inner(node.value)[inner(node.slice)]
            except (LookupError, TypeError):
                raise UnknownConstantError from None
        case ast.Call():
            return _value_of_call(sources, module, node, inner)
        case ast.UnaryOp(op=ast.USub()):
            value = inner(node.operand)
            if isinstance(value, int | float):
                return -value
        case ast.BinOp(op=ast.Add() | ast.Mult() | ast.Sub() | ast.Div()):
            left, right = inner(node.left), inner(node.right)
            numbers = all(isinstance(part, int | float) for part in (left, right))
            if numbers or (isinstance(node.op, ast.Add) and type(left) is type(right) and type(left) in (str, tuple)):
                try:
                    return _OPERATORS[type(node.op)](left, right)
                except ArithmeticError:
                    raise UnknownConstantError from None
        case ast.Lambda():
            return Reference("lambda")
        case ast.JoinedStr():
            return "".join(str(inner(part)) for part in node.values)
        case ast.FormattedValue(conversion=-1, format_spec=None):
            return inner(node.value)
    raise UnknownConstantError


def _dict(node: ast.Dict, inner: Any, inner_or_name: Any) -> dict[Any, Any]:
    table: dict[Any, Any] = {}
    for key, value in zip(node.keys, node.values, strict=True):
        content = inner_or_name(value)
        try:
            table.update(content if isinstance(content, dict) else {} if key is None else {inner(key): content})
        except TypeError:  # the key cannot be one
            raise UnknownConstantError from None
    return table


def _value_of_call(sources: Sources, module: Module, node: ast.Call, inner: Any) -> Any:
    name = resolve_import(module, node.func)
    if name in _COLLECTIONS and len(node.args) == 1:
        value = inner(node.args[0])
        return value if isinstance(value, dict) else tuple(value)
    if name == "dict" and not node.args:
        return {keyword.arg: inner(keyword.value) for keyword in node.keywords if keyword.arg}
    owner = sources.class_of(module, node.func)
    if owner is None:
        raise UnknownConstantError
    return Reference(name_with_dots(node.func) + "()")


def _value_of_name(sources: Sources, module: Module, node: ast.Name | ast.Attribute, depth: int) -> Any:
    if isinstance(node, ast.Attribute) and node.attr in ("value", "name") and isinstance(node.value, ast.Attribute):
        base = evaluate(sources, module, node.value, depth + 1)
        if isinstance(base, Member):
            return base.value if node.attr == "value" else base.name
        raise UnknownConstantError
    name = name_with_dots(node)
    last = name.rpartition(".")[2]
    owner = sources.class_of(module, node.value) if isinstance(node, ast.Attribute) else None
    if owner is not None and is_enum(sources, owner):
        for member, _ in members(sources, owner):
            if member.name == last:
                return member
    defined = sources.definition(module, name) if name else None
    if defined is None:
        if isinstance(node, ast.Name) and node.id in module.imports:
            return Reference(module.imports[node.id])
        raise UnknownConstantError
    where, statement = defined
    if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        return Reference(statement.name)
    for target, value in assignments(statement):
        if isinstance(target, ast.Name) and target.id == last:
            return evaluate(sources, where, value, depth + 1)
    raise UnknownConstantError
