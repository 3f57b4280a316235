"""Which constants reach an expression in a function, through parameters, attributes, tables and what functions return.

It errs on the side of saying less: where one way is not known, the constants of the others remain, as in
`if order == "stop"` of a text that came from outside.
"""

from __future__ import annotations

import ast
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from pytest_hricdv.extra.draft.found.findings import Place
from pytest_hricdv.extra.draft.reading.constants import Member, Reference, UnknownValueError, evaluate
from pytest_hricdv.extra.draft.reading.instances import Instances
from pytest_hricdv.extra.draft.reading.sources import Function, Module, Scope, Sources, dotted_name
from pytest_hricdv.extra.draft.reading.type_tables import Handled, handled

MAX_DEPTH = 12
"""Calls, attributes and names between a constant and its use (chosen)."""

Constants = dict[Any, Place]
"""Constant -> where it is written."""

_SAME = ("strip", "lstrip", "rstrip", "decode", "encode")


@dataclass(frozen=True)
class Call:
    """A call in a function (None: at the top of a module)."""

    module: Module
    scope: Scope | None
    node: ast.Call


@dataclass
class ValueFlow:
    """Follows constants through the code; all look-ups are made once."""

    sources: Sources
    _asked: list[tuple[int, int]] = field(default_factory=list)
    _known: dict[tuple[int, int], Constants] = field(default_factory=dict)

    @cached_property
    def calls(self) -> dict[str, list[Call]]:
        """All calls, by the last part of what is called."""
        by_name: dict[str, list[Call]] = defaultdict(list)
        for module, scope, node in self.nodes:
            if isinstance(node, ast.Call):
                by_name[last_name(node.func)].append(Call(module, scope, node))
        return by_name

    @cached_property
    def nodes(self) -> list[tuple[Module, Scope | None, ast.AST]]:
        """All nodes, each with the innermost function around it."""
        found: list[tuple[Module, Scope | None, ast.AST]] = []
        scopes = {id(scope.node): scope for scope in self.sources.functions}

        def walk(module: Module, scope: Scope | None, node: ast.AST) -> None:
            for child in ast.iter_child_nodes(node):
                found.append((module, scope, child))
                walk(module, scopes.get(id(child), scope), child)

        for module in self.sources.modules:
            walk(module, None, module.tree)
        return found

    @cached_property
    def attributes(self) -> dict[tuple[str, str], list[tuple[Scope, ast.expr]]]:
        """What is assigned to attributes: (class, attribute) -> where, and what."""
        assigned: dict[tuple[str, str], list[tuple[Scope, ast.expr]]] = defaultdict(list)
        for _, scope, node in self.nodes:
            if scope is None or not isinstance(node, ast.Assign | ast.AnnAssign):
                continue
            for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                pairs = [(target, node.value)]
                if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                    pairs = list(zip(target.elts, node.value.elts, strict=False))
                for place, value in pairs:
                    owner = (
                        self.owner_of(place.value, scope.module, scope) if isinstance(place, ast.Attribute) else None
                    )
                    if isinstance(place, ast.Attribute) and owner is not None and value is not None:
                        assigned[owner.name, place.attr].append((scope, value))
        return assigned

    @cached_property
    def methods(self) -> dict[str, list[Scope]]:
        """Functions and methods by name."""
        by_name: dict[str, list[Scope]] = defaultdict(list)
        for scope in self.sources.functions:
            by_name[scope.node.name].append(scope)
        return by_name

    @cached_property
    def _instances(self) -> Instances:
        return Instances(self.sources, self.methods, self.arguments, self.handlers, self._own_attributes)

    @cached_property
    def _own_attributes(self) -> dict[tuple[int, str], list[tuple[Scope, ast.expr]]]:
        """What methods assign to attributes of `self`: (class, by identity, attribute) -> where, and what."""
        assigned: dict[tuple[int, str], list[tuple[Scope, ast.expr]]] = defaultdict(list)
        for _, scope, node in self.nodes:
            if scope is None or scope.owner is None or not isinstance(node, ast.Assign | ast.AnnAssign):
                continue
            for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                if isinstance(target, ast.Attribute) and dotted_name(target.value) == "self" and node.value is not None:
                    assigned[id(scope.owner), target.attr].append((scope, node.value))
        return assigned

    @cached_property
    def handled(self) -> tuple[Handled, ...]:
        """Classes of messages that have a function of their own."""
        return tuple(handled(self.sources, self.nodes, self.methods))

    @cached_property
    def handlers(self) -> dict[int, Handled]:
        """Functions that handle messages of one class only, by the identity of their nodes."""
        count = Counter(id(row.function.node) for row in self.handled)
        return {id(row.function.node): row for row in self.handled if count[id(row.function.node)] == 1}

    def constants(self, expression: ast.AST | None, module: Module, scope: Scope | None) -> Constants:
        """The constants that an expression can be, as far as they are known."""
        key = id(expression), id(scope and scope.node)
        if key in self._known:
            return self._known[key]
        found: Constants = {}
        if key in self._asked or len(self._asked) > MAX_DEPTH:  # what asks for itself adds nothing
            return found
        self._asked.append(key)
        self._add(expression, module, scope, found, set(), 0)
        self._asked.pop()
        if not self._asked:  # else something may be missing that is being asked for
            self._known[key] = found
        return found

    def expressions(
        self, expression: ast.AST | None, module: Module, scope: Scope | None
    ) -> Iterator[tuple[ast.AST, Module, Scope | None]]:
        """The expression, and all that it may come from."""
        seen: set[int] = set()
        waiting: list[tuple[Any, Module, Scope | None, int]] = [(expression, module, scope, 0)]
        while waiting:
            node, where, at, depth = waiting.pop(0)
            if node is None or isinstance(node, tuple) or id(node) in seen or depth > MAX_DEPTH:
                continue
            seen.add(id(node))
            yield node, where, at
            waiting += [(*origin, depth + 1) for origin in self._origins(node, where, at)]

    def is_whole(self, expression: ast.AST, module: Module, scope: Scope | None) -> bool:
        """Whether all that an expression can be is known: each way to it begins with a constant."""
        return all(
            self._is_constant(node, where, at) or any(True for _ in self._origins(node, where, at))
            for node, where, at in self.expressions(expression, module, scope)
        )

    def _is_constant(self, node: ast.AST, module: Module, scope: Scope | None) -> bool:
        if isinstance(node, ast.Name) and scope is not None and node.id in self._locals(scope.node):
            return False
        try:
            evaluate(self.sources, module, node)
        except UnknownValueError:
            return False
        return True

    def _add(
        self, node: ast.AST | None, module: Module, scope: Scope | None, found: Constants, seen: set[Any], depth: int
    ) -> None:
        if node is None or depth > MAX_DEPTH or (id(node), id(scope and scope.node)) in seen:
            return
        seen.add((id(node), id(scope and scope.node)))
        is_local = isinstance(node, ast.Name) and scope is not None and node.id in self._locals(scope.node)
        if not is_local:
            try:
                found.setdefault(_hashable(evaluate(self.sources, module, node)), module.place(node))
            except UnknownValueError:
                pass
            else:
                return
        for part, where, at in self._origins(node, module, scope):
            if isinstance(part, tuple):
                for value in part[1]:
                    found.setdefault(_hashable(value), where.place(part[0]))
            else:
                self._add(part, where, at, found, seen, depth + 1)

    def _origins(
        self, node: ast.AST, module: Module, scope: Scope | None
    ) -> Iterator[tuple[Any, Module, Scope | None]]:
        """What an expression comes from: other expressions, or constants of a table (a node with a tuple)."""
        if isinstance(node, ast.Await | ast.NamedExpr | ast.Starred):
            yield node.value, module, scope
        elif isinstance(node, ast.IfExp):
            yield node.body, module, scope
            yield node.orelse, module, scope
        elif isinstance(node, ast.BoolOp):
            for value in node.values:
                yield value, module, scope
        elif isinstance(node, ast.Subscript):
            yield from self._items(node, node.value, module, scope)
        elif isinstance(node, ast.Name) and scope is not None:
            yield from self._local(node.id, module, scope)
        elif isinstance(node, ast.Attribute):
            yield from self._attribute(node, module, scope)
        elif isinstance(node, ast.Call):
            yield from self._returned(node, module, scope)

    def _items(
        self, node: ast.AST, table: ast.expr, module: Module, scope: Scope | None
    ) -> Iterator[tuple[Any, Module, Scope | None]]:
        for value in self.constants(table, module, scope):
            content = dict(value.pairs) if isinstance(value, _Table) else value
            if isinstance(content, dict):
                yield (node, tuple(content.values())), module, scope
            elif isinstance(content, tuple):
                yield (node, content), module, scope

    def elements(self, iterable: ast.expr, module: Module, scope: Scope | None) -> tuple[Any, ...]:
        """Over which constants a loop can go."""
        elements: list[Any] = []
        for value in self.constants(iterable, module, scope):
            content = [key for key, _ in value.pairs] if isinstance(value, _Table) else value
            if isinstance(content, tuple | list):
                elements += content
        return tuple(elements)

    def _local(self, name: str, module: Module, scope: Scope) -> Iterator[tuple[Any, Module, Scope | None]]:
        function = scope.node
        assert not isinstance(function, ast.ClassDef)
        parameters = parameter_names(function)
        if name in parameters:
            yield from self.arguments(scope, name)
        for node in ast.walk(function):
            if isinstance(node, ast.Assign | ast.AnnAssign):
                for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                    if isinstance(target, ast.Name) and target.id == name:
                        yield node.value, module, scope
                    elif isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                        for part, value in zip(target.elts, node.value.elts, strict=False):
                            if isinstance(part, ast.Name) and part.id == name:
                                yield value, module, scope
            elif isinstance(node, ast.NamedExpr) and node.target.id == name:
                yield node.value, module, scope
            elif isinstance(node, ast.For | ast.AsyncFor | ast.comprehension):
                yield from self._loop(node, name, module, scope)

    def _loop(
        self, node: ast.For | ast.AsyncFor | ast.comprehension, name: str, module: Module, scope: Scope
    ) -> Iterator[tuple[Any, Module, Scope | None]]:
        if isinstance(node.target, ast.Name) and node.target.id == name:
            yield (node.iter, self.elements(node.iter, module, scope)), module, scope
        elif isinstance(node.target, ast.Tuple):
            for index, part in enumerate(node.target.elts):
                if isinstance(part, ast.Name) and part.id == name:
                    rows = [row for row in self.elements(node.iter, module, scope) if isinstance(row, tuple)]
                    yield (node.iter, tuple(row[index] for row in rows if len(row) > index)), module, scope

    def arguments(self, scope: Scope, name: str) -> Iterator[tuple[Any, Module, Scope | None]]:
        """What a parameter is called with."""
        function = scope.node
        assert not isinstance(function, ast.ClassDef)
        called = scope.owner.name if scope.owner is not None and function.name == "__init__" else function.name
        for call in self.calls[called]:
            value = argument_of(call.node, function, name, is_method=scope.owner is not None)
            if value is not None:
                yield value, call.module, call.scope
        default = default_of(function, name)
        if default is not None:
            yield default, scope.module, None

    def _attribute(
        self, node: ast.Attribute, module: Module, scope: Scope | None
    ) -> Iterator[tuple[Any, Module, Scope | None]]:
        if node.attr in ("value", "name"):
            yield node.value, module, scope
        owner = self.owner_of(node.value, module, scope)
        if owner is not None:
            for where, value in self.attributes.get((owner.name, node.attr), ()):
                yield value, where.module, where
            for statement in owner.body:
                if isinstance(statement, ast.Assign | ast.AnnAssign):
                    targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
                    if any(isinstance(target, ast.Name) and target.id == node.attr for target in targets):
                        yield statement.value, module, None
            for method in self.methods[node.attr]:
                if method.owner is owner:
                    yield from self._returns(method)

    def owner_of(self, expression: ast.expr, module: Module, scope: Scope | None) -> ast.ClassDef | None:
        """The class of the code whose instance an expression is, see `Instances`."""
        return self._instances.class_of(expression, module, scope)

    def _returned(
        self, node: ast.Call, module: Module, scope: Scope | None
    ) -> Iterator[tuple[Any, Module, Scope | None]]:
        name = last_name(node.func)
        if isinstance(node.func, ast.Attribute) and name in _SAME:
            yield node.func.value, module, scope
        if isinstance(node.func, ast.Attribute) and name == "get" and node.args:
            yield from self._items(node, node.func.value, module, scope)
            if len(node.args) > 1:
                yield node.args[1], module, scope
        if name in ("str", "cast", "reversed", "sorted", "tuple", "list", "choice") and node.args:
            yield node.args[-1], module, scope
        if isinstance(node.func, ast.Subscript):  # a table of functions
            for value in self.constants(node.func.value, module, scope):
                for _, content in getattr(value, "pairs", ()):
                    last = content.name.rpartition(".")[2] if isinstance(content, Reference) else ""
                    for method in self.methods.get(last, ())[:1]:
                        yield from self._returns(method)
        called = self._called(node.func, module, scope)
        if called is not None:
            yield from self._returns(called)

    def _called(self, called: ast.expr, module: Module, scope: Scope | None) -> Scope | None:
        """The function of the code that is called by its name, or as a method of an instance; None: it is not known."""
        methods = self.methods[last_name(called)]
        owner = self.owner_of(called.value, module, scope) if isinstance(called, ast.Attribute) else None
        if not isinstance(called, ast.Name) and owner is None and not dotted_name(called).startswith("self."):
            return None
        if len(methods) > 1 and isinstance(called, ast.Name):
            methods = [method for method in methods if method.owner is None and method.module is module]
        elif len(methods) > 1:
            methods = [method for method in methods if owner is not None and method.owner is owner]
        return methods[0] if len(methods) == 1 else None

    def _returns(self, scope: Scope) -> Iterator[tuple[Any, Module, Scope | None]]:
        for node in ast.walk(scope.node):
            if isinstance(node, ast.Return) and node.value is not None:
                yield node.value, scope.module, scope

    def _locals(self, function: ast.AST) -> set[str]:
        key = id(function)
        cache: dict[int, set[str]] = self.__dict__.setdefault("_locals_of", {})
        if key not in cache:
            names = {
                node.id for node in ast.walk(function) if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
            }
            shared = {name for node in ast.walk(function) if isinstance(node, ast.Global) for name in node.names}
            assert isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef)
            cache[key] = (names | set(parameter_names(function))) - shared
        return cache[key]


@dataclass(frozen=True)
class _Table:
    """A dict that can be a key."""

    pairs: tuple[tuple[Any, Any], ...]


def _hashable(value: Any) -> Any:
    if isinstance(value, dict):
        return _Table(tuple((key, _hashable(content)) for key, content in value.items()))
    if isinstance(value, tuple):
        return tuple(_hashable(content) for content in value)
    return value


def texts(values: Constants) -> dict[str, Place]:
    """Those that are texts or members of enumerations, as the record calls them."""
    found: dict[str, Place] = {}
    for value, place in values.items():
        if isinstance(value, Member):
            found.setdefault(value.text, place)
        elif isinstance(value, str) and value:
            found.setdefault(value, place)
    return found


def references(values: Constants) -> list[str]:
    """Names of functions and classes among them."""
    return [value.name for value in values if isinstance(value, Reference) and value.name]


def parameter_names(function: Function) -> list[str]:
    """Of positional and keyword parameters, in their order."""
    arguments = function.args
    return [part.arg for part in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)]


def default_of(function: Function, name: str) -> ast.expr | None:
    """The default of a parameter; None where it has none."""
    positional = [part.arg for part in (*function.args.posonlyargs, *function.args.args)]
    defaults = function.args.defaults
    if name in positional:
        index = positional.index(name) - (len(positional) - len(defaults))
        return defaults[index] if index >= 0 else None
    for part, default in zip(function.args.kwonlyargs, function.args.kw_defaults, strict=True):
        if part.arg == name:
            return default
    return None


def argument_of(call: ast.Call, function: Function, name: str, is_method: bool) -> ast.expr | None:
    """What a call hands over for a parameter; None where it does not say."""
    for keyword in call.keywords:
        if keyword.arg == name:
            return keyword.value
    names = parameter_names(function)
    if is_method and not any(last_name(decorator) == "staticmethod" for decorator in function.decorator_list):
        names = names[1:]
    if name in names and names.index(name) < len(call.args):
        value = call.args[names.index(name)]
        if not any(isinstance(argument, ast.Starred) for argument in call.args[: names.index(name) + 1]):
            return value
    return None


def last_name(node: ast.AST) -> str:
    """The last part of a name: `self._bus.publish` -> `publish`; empty for what is no name."""
    if isinstance(node, ast.Name):
        return node.id
    return node.attr if isinstance(node, ast.Attribute) else ""
