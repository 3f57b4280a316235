"""What expressions of a module's top level come to, without running it: constants, tables, members of enumerations."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.extra.draft.code.sources import Module, Scope, Sources, dotted_name, imported_name

MAX_DEPTH = 30
"""Names that lead to names: deeper ones go round (chosen)."""

MAX_SIZE = 10_000
"""Of a table or text that is computed (chosen: more than anybody writes by hand)."""


class UnknownValueError(Exception):
    """It cannot be said without running the code."""


@dataclass(frozen=True)
class Reference:
    """A function or class of the code, or a name from outside."""

    name: str


@dataclass(frozen=True)
class Member:
    """A member of an enumeration; `value` is a constant where it is one."""

    enum: str
    name: str
    value: Any

    @property
    def text(self) -> str:
        """How the record calls it: by its value if this is a text, else by its name."""
        return self.value if isinstance(self.value, str) else self.name


ENUMS = ("Enum", "IntEnum", "StrEnum", "Flag", "IntFlag")
_OPERATORS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.BitOr: operator.or_,
}
_COLLECTIONS = ("tuple", "list", "set", "frozenset", "dict", "sorted", "MappingProxyType", "types.MappingProxyType")


def is_enum(sources: Sources, scope: Scope) -> bool:
    """Whether a class is an enumeration."""
    return any(base.rpartition(".")[2] in ENUMS for base in sources.bases(scope))


def members(sources: Sources, scope: Scope) -> tuple[tuple[Member, ast.stmt], ...]:
    """The members of an enumeration, with where they are defined."""
    found: list[tuple[Member, ast.stmt]] = []
    assert isinstance(scope.node, ast.ClassDef)
    is_text = any(base.rpartition(".")[2] == "StrEnum" for base in sources.bases(scope))
    for statement in scope.node.body:
        if not (isinstance(statement, ast.Assign) and len(statement.targets) == 1):
            continue
        target = statement.targets[0]
        names = target.elts if isinstance(target, ast.Tuple) else [target]
        values = (
            statement.value.elts if isinstance(statement.value, ast.Tuple) and len(names) > 1 else [statement.value]
        )
        for name, value in zip(names, values, strict=False):
            if not isinstance(name, ast.Name) or name.id.startswith("_"):
                continue
            try:
                content = evaluate(sources, scope.module, value)
            except UnknownValueError:
                is_auto = isinstance(value, ast.Call) and dotted_name(value.func).endswith("auto")
                content = name.id.lower() if is_auto and is_text else None
            found.append((Member(scope.node.name, name.id, content), statement))
    return tuple(found)


def evaluate(sources: Sources, module: Module, node: ast.AST | None, depth: int = 0) -> Any:
    """What an expression comes to: constants, tuples (also for lists and sets), dicts, `Member`, `Reference`.

    Raises:
        UnknownValueError: it cannot be said.
    """
    if depth > MAX_DEPTH:
        raise UnknownValueError

    def inner(child: ast.AST | None) -> Any:
        return evaluate(sources, module, child, depth + 1)

    if isinstance(node, ast.Constant):
        return node.value
    if isinstance(node, ast.Tuple | ast.List | ast.Set):
        return _sequence(node.elts, inner)
    if isinstance(node, ast.JoinedStr):
        parts = [part.value if isinstance(part, ast.FormattedValue) else part for part in node.values]
        return "".join(str(inner(part)) for part in parts)
    if isinstance(node, ast.Dict):
        return _table(node, inner)
    if isinstance(node, ast.Name | ast.Attribute):
        return _named(sources, module, node, depth)
    if isinstance(node, ast.Call):
        return _called(sources, module, node, inner)
    if isinstance(node, ast.Subscript):
        return _item(inner(node.value), inner(node.slice))
    if isinstance(node, ast.BinOp | ast.UnaryOp):
        return _computed(node, inner)
    if isinstance(node, ast.Lambda):
        return Reference("lambda")
    raise UnknownValueError


def _sequence(elements: list[ast.expr], inner: Callable[[ast.AST | None], Any]) -> tuple[Any, ...]:
    values: list[Any] = []
    for element in elements:
        if isinstance(element, ast.Starred):
            values += list(inner(element.value))
        else:
            values.append(_or_opaque(element, inner))
    return tuple(values)


def _table(node: ast.Dict, inner: Callable[[ast.AST | None], Any]) -> dict[Any, Any]:
    table: dict[Any, Any] = {}
    for key, value in zip(node.keys, node.values, strict=True):
        content = _or_opaque(value, inner)
        if key is None:
            table.update(content if isinstance(content, dict) else {})
            continue
        name = inner(key)
        try:
            table[name] = content
        except TypeError:
            raise UnknownValueError from None
    return table


def _or_opaque(value: ast.expr, inner: Callable[[ast.AST | None], Any]) -> Any:
    """A value of a table that cannot be said is a reference, `self.move` or nameless: the others still count."""
    try:
        return inner(value)
    except UnknownValueError:
        return Reference(dotted_name(value))


def _item(base: Any, key: Any) -> Any:
    try:
        return base[key]
    except (KeyError, IndexError, TypeError):
        raise UnknownValueError from None


def _computed(node: ast.BinOp | ast.UnaryOp, inner: Callable[[ast.AST | None], Any]) -> Any:
    if isinstance(node, ast.UnaryOp):
        value = inner(node.operand)
        if isinstance(node.op, ast.USub) and isinstance(value, int | float):
            return -value
        raise UnknownValueError
    combine = _OPERATORS.get(type(node.op))
    left, right = inner(node.left), inner(node.right)
    if isinstance(left, tuple) and isinstance(node.op, ast.BitOr):
        return tuple(dict.fromkeys([*left, *right]))
    if combine is None or (isinstance(left, str) and not isinstance(node.op, ast.Add)):
        raise UnknownValueError
    try:
        value = combine(left, right)
    except (TypeError, ValueError, ArithmeticError):
        raise UnknownValueError from None
    if isinstance(value, str | tuple) and len(value) > MAX_SIZE:
        raise UnknownValueError
    return value


def _called(sources: Sources, module: Module, node: ast.Call, inner: Callable[[ast.AST | None], Any]) -> Any:
    name = imported_name(module, node.func)
    if name in _COLLECTIONS and len(node.args) == 1:
        value = inner(node.args[0])
        return value if isinstance(value, dict) and name != "sorted" else tuple(value)
    if name.rpartition(".")[2] in ("field", "Field"):
        return _default(node, inner)
    if name == "dict" and not node.args:
        return {keyword.arg: inner(keyword.value) for keyword in node.keywords if keyword.arg}
    if isinstance(node.func, ast.Attribute) and node.func.attr in ("keys", "values") and not node.args:
        table = inner(node.func.value)
        if isinstance(table, dict):
            return tuple(table if node.func.attr == "keys" else table.values())
    if name == "set" and not node.args:
        return ()
    owner = sources.class_of(module, node.func)
    if owner is not None and is_enum(sources, owner) and node.args:
        value = inner(node.args[0])
        for member, _ in members(sources, owner):
            if member.value == value:
                return member
    if owner is not None:
        return Reference(dotted_name(node.func) + "()")
    raise UnknownValueError


def _default(node: ast.Call, inner: Callable[[ast.AST | None], Any]) -> Any:
    """The default of a field of a dataclass or model: `field(default_factory=lambda: {"bolt": 1})`."""
    for keyword in node.keywords:
        if keyword.arg == "default":
            return inner(keyword.value)
        if keyword.arg in ("default_factory", "factory") and isinstance(keyword.value, ast.Lambda):
            return inner(keyword.value.body)
    raise UnknownValueError


def _named(sources: Sources, module: Module, node: ast.Name | ast.Attribute, depth: int) -> Any:
    if isinstance(node, ast.Attribute) and node.attr in ("value", "name") and isinstance(node.value, ast.Attribute):
        base = evaluate(sources, module, node.value, depth + 1)
        if isinstance(base, Member):
            return base.value if node.attr == "value" else base.name
        raise UnknownValueError
    name = dotted_name(node)
    owner = sources.class_of(module, node.value) if isinstance(node, ast.Attribute) else None
    if owner is not None and is_enum(sources, owner):
        for member, _ in members(sources, owner):
            if member.name == name.rpartition(".")[2]:
                return member
    defined = sources.definition(module, name) if name else None
    if defined is None:
        if isinstance(node, ast.Name) and node.id in module.imports:
            return Reference(module.imports[node.id])
        raise UnknownValueError
    where, statement = defined
    if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        return Reference(statement.name)
    return _assigned(sources, where, statement, name.rpartition(".")[2], depth)


def _assigned(sources: Sources, module: Module, statement: ast.stmt, name: str, depth: int) -> Any:
    if isinstance(statement, ast.AnnAssign):
        return evaluate(sources, module, statement.value, depth + 1)
    if not isinstance(statement, ast.Assign):
        raise UnknownValueError
    for target in statement.targets:
        if isinstance(target, ast.Name) and target.id == name:
            return evaluate(sources, module, statement.value, depth + 1)
        if isinstance(target, ast.Tuple):
            for index, element in enumerate(target.elts):
                if isinstance(element, ast.Name) and element.id == name:
                    if isinstance(statement.value, ast.Tuple):
                        return evaluate(sources, module, statement.value.elts[index], depth + 1)
                    if isinstance(statement.value, ast.Call) and imported_name(module, statement.value.func) == "range":
                        return index
                    return _item(evaluate(sources, module, statement.value, depth + 1), index)
    raise UnknownValueError
