"""Data-flow analysis: which constants and expressions reach an expression, through names, parameters and attributes.

All readers of the code share one `Flow`. It errs on the side of less: what is over `MAX_STEPS` away is not known.
"""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from pytest_hricdv.extra.draft.code.constants import Member, UnknownConstantError, assignments, evaluate
from pytest_hricdv.extra.draft.code.sources import Function, Module, Scope, Sources, name_with_dots
from pytest_hricdv.extra.draft.code_model import CodeLine

MAX_STEPS = 4
"""Most steps from an expression to its constant: a local name, a parameter's argument, an attribute, a return value."""

Origin = tuple[ast.expr, Module, Scope | None]
"""An expression, with the module and function in which it stands."""

SAME = ("strip", "lstrip", "rstrip", "decode", "encode", "lower", "upper", "casefold", "split")
"""Methods of strings and bytes whose result is compared as the value itself, or its words."""


@dataclass(frozen=True)
class CallSite:
    """A call in a function (None: at the top of a module)."""

    module: Module
    scope: Scope | None
    node: ast.Call


@dataclass
class Flow:
    """Follows values through the code; all look-up tables are made once."""

    sources: Sources
    _names: dict[int, dict[str, list[ast.Name]]] = field(default_factory=dict)

    @cached_property
    def nodes(self) -> list[tuple[Module, Scope | None, ast.AST]]:
        """All nodes, each with the innermost function around it."""
        scopes = {id(scope.node): scope for scope in self.sources.functions}
        waiting: list[tuple[Module, Scope | None, ast.AST]] = [(m, None, m.tree) for m in self.sources.modules[::-1]]
        nodes = []
        while waiting:
            module, scope, node = waiting.pop()
            children = [(module, scopes.get(id(node), scope), child) for child in ast.iter_child_nodes(node)]
            nodes.append((module, scope, node))
            waiting += children[::-1]
        return nodes

    @cached_property
    def parents(self) -> dict[int, ast.AST]:
        """The parents of each node, by the identity of the node."""
        return {id(child): node for _, _, node in self.nodes for child in ast.iter_child_nodes(node)}

    @cached_property
    def calls(self) -> dict[str, list[CallSite]]:
        """All calls, by the last part of what is called."""
        by_name: dict[str, list[CallSite]] = defaultdict(list)
        for module, scope, node in self.nodes:
            if isinstance(node, ast.Call):
                by_name[last_name(node.func)].append(CallSite(module, scope, node))
        return by_name

    @cached_property
    def methods(self) -> dict[str, list[Scope]]:
        """Functions and methods by name."""
        by_name: dict[str, list[Scope]] = defaultdict(list)
        for scope in self.sources.functions:
            by_name[scope.node.name].append(scope)
        return by_name

    @cached_property
    def attributes(self) -> dict[tuple[int, str], list[tuple[Scope, ast.expr]]]:
        """Assignments of methods to attributes of `self`: (identity of the class, attribute) -> where, and what."""
        assigned: dict[tuple[int, str], list[tuple[Scope, ast.expr]]] = defaultdict(list)
        for _, scope, node in self.nodes:
            if scope is not None and scope.owner is not None:
                for target, value in assignments(node):
                    if isinstance(target, ast.Attribute) and name_with_dots(target.value) == "self":
                        assigned[id(scope.owner), target.attr].append((scope, value))
        return assigned

    def names_in(self, scope: Scope) -> dict[str, list[ast.Name]]:
        """The nodes of each name in a function; looked up once."""
        key = id(scope.node)
        if key not in self._names:
            found = self._names[key] = defaultdict(list)
            for node in ast.walk(scope.node):
                if isinstance(node, ast.Name):
                    found[node.id].append(node)
        return self._names[key]

    def owner_of(
        self, expression: ast.expr, module: Module, scope: Scope | None, steps: int = 0
    ) -> ast.ClassDef | None:
        """The class of `self`, of a new instance, or of an annotated parameter or attribute; None: not known."""
        if name_with_dots(expression) == "self" and scope is not None:
            return scope.owner
        if isinstance(expression, ast.Call):
            own = self.sources.class_of(module, expression.func)
            return own.node if own is not None and isinstance(own.node, ast.ClassDef) else None
        if isinstance(expression, ast.Attribute) and steps < MAX_STEPS:
            owner = self.owner_of(expression.value, module, scope, steps + 1)
            for where, value in self._values_of(owner, module, expression.attr):
                made = self.owner_of(value, where.module, where, steps + 1)
                if made is not None:
                    return made
        if isinstance(expression, ast.Name) and scope is not None and not isinstance(scope.node, ast.ClassDef):
            annotation = annotation_of(scope.node, expression.id)
            own = self.sources.class_of(module, annotation) if annotation is not None else None
            if own is not None and isinstance(own.node, ast.ClassDef):
                return own.node
            arguments = self._arguments(scope, scope.node, expression.id) if steps < MAX_STEPS else ()
            owners = (self.owner_of(value, where, at, steps + 1) for value, where, at in arguments)
            return next((owner for owner in owners if owner is not None), None)
        return None

    def _values_of(self, owner: ast.ClassDef | None, module: Module, name: str) -> list[tuple[Scope, ast.expr]]:
        """The values that a class, or else its bases, assign to an attribute."""
        if owner is None:
            return []
        bases = [base.node for base in self.sources.base_classes(Scope(module, owner))]
        return next((self.attributes[id(class_), name] for class_ in (owner, *bases)
                     if (id(class_), name) in self.attributes), [])  # fmt: skip

    def constants(self, expression: ast.AST | None, module: Module, scope: Scope | None) -> list[tuple[Any, CodeLine]]:
        """The constants that an expression can be, as far as they are known, each with its location."""
        constants: list[tuple[Any, CodeLine]] = []
        for node, where, at in self.expressions(expression, module, scope):
            if not self._is_local(node, at):
                try:
                    value = evaluate(self.sources, where, node)
                except UnknownConstantError:
                    continue
                if all(value != other or type(value) is not type(other) for other, _ in constants):
                    constants.append((value, where.location(node)))
        return constants

    def values(self, expression: ast.AST | None, module: Module, scope: Scope | None) -> list[Any]:
        """The values without locations."""
        return [value for value, _ in self.constants(expression, module, scope)]

    def numbers(self, expression: ast.AST | None, module: Module, scope: Scope | None) -> list[float]:
        """The values that are numbers."""
        values = self.values(expression, module, scope)
        return [float(value) for value in values if isinstance(value, int | float) and not isinstance(value, bool)]

    def expressions(self, expression: ast.AST | None, module: Module, scope: Scope | None) -> Iterator[Origin]:
        """The expression, and all that it may come from."""
        seen: set[int] = set()
        waiting: list[tuple[Any, Module, Scope | None, int]] = [(expression, module, scope, 0)]
        while waiting:
            node, where, at, steps = waiting.pop(0)
            if not isinstance(node, ast.expr) or id(node) in seen or steps > MAX_STEPS:
                continue
            seen.add(id(node))
            yield node, where, at
            is_plain = isinstance(node, ast.Await | ast.NamedExpr | ast.IfExp | ast.BoolOp)
            waiting += [(*origin, steps + (not is_plain)) for origin in self._origins(node, where, at)]

    def receivers(self, call: ast.Call, argument: ast.expr) -> Iterator[tuple[Scope, str]]:
        """The functions of the code that a call may pass an argument to, each with the parameter that gets it."""
        for function in self.methods.get(last_name(call.func), ()):
            assert not isinstance(function.node, ast.ClassDef)
            for name in parameter_names(function.node):
                if argument_of(call, function.node, name, is_method=function.owner is not None) is argument:
                    yield function, name

    def is_complete(self, expression: ast.AST, module: Module, scope: Scope | None) -> bool:
        """Whether all that an expression can be is known: each way to it begins with a constant."""
        return all(
            self.constants(node, where, at) or any(True for _ in self._origins(node, where, at))
            for node, where, at in self.expressions(expression, module, scope)
        )

    def _is_local(self, node: ast.expr, scope: Scope | None) -> bool:
        """Whether a name is one of a function: then no constant of its module."""
        if not isinstance(node, ast.Name) or scope is None or isinstance(scope.node, ast.ClassDef):
            return False
        uses = self.names_in(scope).get(node.id, ())
        return node.id in parameter_names(scope.node) or any(isinstance(part.ctx, ast.Store) for part in uses)

    def _origins(self, node: ast.expr, module: Module, scope: Scope | None) -> Iterator[Origin]:
        """The origins of an expression, one step back."""
        if isinstance(node, ast.Await | ast.NamedExpr):
            yield node.value, module, scope
        elif isinstance(node, ast.IfExp):
            yield from ((part, module, scope) for part in (node.body, node.orelse))
        elif isinstance(node, ast.BoolOp):
            yield from ((value, module, scope) for value in node.values)
        elif isinstance(node, ast.Name) and scope is not None:
            yield from self._local(node.id, module, scope)
        elif isinstance(node, ast.Attribute):
            yield from self._attribute(node, module, scope)
        elif isinstance(node, ast.Call):
            if isinstance(node.func, ast.Attribute) and node.func.attr in SAME:
                yield node.func.value, module, scope
            called = self._callee(node.func, scope)
            for part in ast.walk(called.node) if called is not None else ():
                if isinstance(part, ast.Return) and part.value is not None and called is not None:
                    yield part.value, called.module, called

    def _local(self, name: str, module: Module, scope: Scope) -> Iterator[Origin]:
        function = scope.node
        assert not isinstance(function, ast.ClassDef)
        if name in parameter_names(function):
            yield from self._arguments(scope, function, name)
        for node in ast.walk(function):
            for target, value in assignments(node):
                if isinstance(target, ast.Name) and target.id == name:
                    yield value, module, scope

    def _arguments(self, scope: Scope, function: Function, name: str) -> Iterator[Origin]:
        """The arguments passed for a parameter."""
        is_begin = scope.owner is not None and function.name == "__init__"
        for call in self._constructions[id(scope.owner)] if is_begin else self.calls[function.name]:
            value = argument_of(call.node, function, name, is_method=scope.owner is not None)
            if value is not None:
                yield value, call.module, call.scope
        default = default_of(function, name)
        if default is not None:
            yield default, scope.module, None

    @cached_property
    def _constructions(self) -> dict[int, list[CallSite]]:
        """The calls that run the constructor of a class: of those that derive from it and have none, or call it."""
        found: dict[int, list[CallSite]] = defaultdict(list)
        for scope in self.sources.classes:
            above = (scope, *self.sources.base_classes(scope))
            begins = [base.node for base in above for part in base.node.body if getattr(part, "name", "") == "__init__"]
            found[id(begins[0] if begins else scope.node)] += self.calls[scope.node.name]
            if len(begins) > 1:
                found[id(begins[1])] += [call for call in self.calls["__init__"]
                                         if call.scope is not None and call.scope.owner is begins[0]]  # fmt: skip
        return found

    def _attribute(self, node: ast.Attribute, module: Module, scope: Scope | None) -> Iterator[Origin]:
        if node.attr in ("value", "name"):  # of a member of an enumeration
            yield node.value, module, scope
        owner = self.owner_of(node.value, module, scope)
        if owner is None:
            return
        for where, value in self.attributes.get((id(owner), node.attr), ()):
            yield value, where.module, where
        for statement in owner.body:
            for target, value in assignments(statement):
                if isinstance(target, ast.Name) and target.id == node.attr:
                    yield value, module, None

    def _callee(self, called: ast.expr, scope: Scope | None) -> Scope | None:
        """The function of the code that is called by its name, or as a method of `self`; None: it is not known."""
        name = name_with_dots(called)
        owner = scope.owner if scope is not None and name.startswith("self.") and name.count(".") == 1 else None
        if "." in name and owner is None:
            return None
        methods = [method for method in self.methods.get(last_name(called), ()) if method.owner is owner]
        return methods[0] if len(methods) == 1 else None


def texts(constants: list[tuple[Any, CodeLine]]) -> dict[str, CodeLine]:
    """The constants that are strings or members of enumerations, in the record's words; also those of tuples and
    dicts."""
    found: dict[str, CodeLine] = {}
    for value, location in constants:
        for part in value if isinstance(value, tuple | dict) else (value,):
            text = part.text if isinstance(part, Member) else part
            text = text.decode("utf-8", "replace") if isinstance(text, bytes) else text
            if isinstance(text, str) and text:
                found.setdefault(text, location)
    return found


def parameters_of(function: Function) -> list[ast.arg]:
    """Positional and keyword parameters, in their order."""
    return [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]


def parameter_names(function: Function) -> list[str]:
    """Their names."""
    return [parameter.arg for parameter in parameters_of(function)]


def annotation_of(function: Function, name: str) -> ast.expr | None:
    """The annotation of a parameter; None if it has none."""
    return next((part.annotation for part in parameters_of(function) if part.arg == name), None)


def default_of(function: Function, name: str) -> ast.expr | None:
    """The default of a parameter; None if it has none."""
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
    """The argument of a call for a parameter; None if it is not known."""
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
    """The last part of a name: `self._bus.publish` -> `publish`; empty for what is not a name."""
    if isinstance(node, ast.Name):
        return node.id
    return node.attr if isinstance(node, ast.Attribute) else ""
