"""What code does with something that it is handed: the attributes that it reads and sets, the methods that it calls."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import replace
from itertools import zip_longest
from keyword import iskeyword

from pytest_hricdv.extra.draft.found.port import Operation, Part
from pytest_hricdv.extra.draft.reading.classes import methods_of
from pytest_hricdv.extra.draft.reading.naming import unit_of
from pytest_hricdv.extra.draft.reading.sources import Module, Scope, Sources, dotted_name
from pytest_hricdv.extra.draft.reading.uses import UseFinder, one_of
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow, argument_of, last_name, parameter_names
from pytest_hricdv.extra.draft.surroundings.motion_words import axis

MAX_DEPTH = 6
"""So often a port may be handed on (chosen)."""


class OperationFinder:
    """Finds the operations on parameters of functions and on attributes of classes."""

    def __init__(self, sources: Sources, flow: ValueFlow) -> None:
        self._sources, self._flow = sources, flow
        self._uses = UseFinder(flow)

    def of_parameter(self, scope: Scope, name: str, depth: int) -> Iterator[Operation]:
        """What a function does with a parameter, and those do that it hands it on to."""
        if depth > MAX_DEPTH:
            return
        for node in ast.walk(scope.node):
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id == name:
                yield self._operation(node, scope.module)
            elif isinstance(node, ast.Call):
                if isinstance(node.func, ast.Name) and node.func.id == name:
                    yield Operation("__call__", "method", (), "", scope.module.place(node))
                yield from self._handed_on(node, scope, name, depth)
            elif isinstance(node, ast.Assign | ast.AnnAssign) and scope.owner is not None:
                for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                    pairs = [(target, node.value)]
                    if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                        pairs = list(zip(target.elts, node.value.elts, strict=False))
                    for part, value in pairs:
                        if isinstance(value, ast.Name) and value.id == name and dotted_name(part).startswith("self."):
                            yield from self.of_attribute(scope.owner, dotted_name(part)[5:], depth + 1)

    def _handed_on(self, node: ast.Call, scope: Scope, name: str, depth: int) -> Iterator[Operation]:
        arguments = [*node.args, *(keyword.value for keyword in node.keywords)]
        if not any(isinstance(argument, ast.Name) and argument.id == name for argument in arguments):
            return
        for callee in self._callees(node, scope):
            assert not isinstance(callee.node, ast.ClassDef)
            for parameter in parameter_names(callee.node):
                value = argument_of(node, callee.node, parameter, is_method=callee.owner is not None)
                if isinstance(value, ast.Name) and value.id == name:
                    yield from self.of_parameter(callee, parameter, depth + 1)

    def _callees(self, node: ast.Call, scope: Scope) -> list[Scope]:
        own = self._sources.class_of(scope.module, node.func)
        if own is not None:
            begin = methods_of(self._sources, own).get("__init__")
            return [begin] if begin is not None else []
        methods = self._flow.methods.get(last_name(node.func), [])
        return methods if len(methods) == 1 else [method for method in methods if method.owner is scope.owner]

    def of_attribute(self, owner: ast.ClassDef, attribute: str, depth: int) -> Iterator[Operation]:
        """What is done with an attribute of a class."""
        if depth > MAX_DEPTH:
            return
        for module, scope, node in self._flow.nodes:
            if scope is None:
                continue
            if isinstance(node, ast.Attribute) and self._is_attribute(node.value, owner, attribute, scope):
                yield self._operation(node, module)
            elif isinstance(node, ast.Call):
                if self._is_attribute(node.func, owner, attribute, scope):
                    yield Operation("__call__", "method", (), "", module.place(node))
                for callee in self._callees(node, scope) if node.args or node.keywords else ():
                    assert not isinstance(callee.node, ast.ClassDef)
                    for parameter in parameter_names(callee.node):
                        value = argument_of(node, callee.node, parameter, is_method=callee.owner is not None)
                        if value is not None and self._is_attribute(value, owner, attribute, scope):
                            yield from self.of_parameter(callee, parameter, depth + 1)

    def _is_attribute(self, node: ast.expr, owner: ast.ClassDef, attribute: str, scope: Scope) -> bool:
        return (
            isinstance(node, ast.Attribute)
            and node.attr == attribute
            and self._flow.owner_of(node.value, scope.module, scope) is owner
        )

    def _operation(self, node: ast.Attribute, module: Module) -> Operation:
        parent = self._uses.parents.get(id(node))
        place = module.place(node)
        if isinstance(parent, ast.Call) and parent.func is node:
            names = argument_names(parent)
            told = [*parent.args, *(keyword.value for keyword in parent.keywords if keyword.arg)]
            above = self._uses.parents.get(id(parent))
            is_async = isinstance(above, ast.Await)
            value = above if is_async and above is not None else parent
            uses = self._uses.of(value, module)
            told_kinds = tuple(self._kind_of(argument, module) for argument in told)
            return Operation(node.attr, "method", names, uses.kind(node.attr), place, is_async, compared=uses.compared,
                             usual=uses.usual, told=told_kinds, parts=self._unpacked(value))  # fmt: skip
        is_set = isinstance(node.ctx, ast.Store)
        uses = self._uses.of(node, module)
        kinds: tuple[str, ...] = ()
        if is_set:
            kinds = (self._kind_of(parent.value, module) if isinstance(parent, ast.Assign | ast.AnnAssign) else "",)
        return Operation(node.attr, "attribute", (), uses.kind(node.attr), place, is_set=is_set,
                         compared=uses.compared, told=kinds, usual=uses.usual, parts=self._unpacked(node))  # fmt: skip

    def _unpacked(self, node: ast.AST) -> tuple[Part, ...]:
        """The parts of a tuple that the code unpacks, `x, y, heading = base.pose()`."""
        parent = self._uses.parents.get(id(node))
        targets = parent.targets if isinstance(parent, ast.Assign) and parent.value is node else []
        for target in targets:
            if isinstance(target, ast.Tuple) and not any(isinstance(part, ast.Starred) for part in target.elts):
                return tuple(_part(last_name(part)) for part in target.elts)
        return ()

    def _kind_of(self, node: ast.expr | None, module: Module) -> str:
        """The kind of what a port is told: "bool", "float", "str"; empty where the code does not say one."""
        is_negation = isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not)
        if isinstance(node, ast.Compare | ast.BoolOp) or is_negation:
            return "bool"
        if isinstance(node, ast.JoinedStr):
            return "str"
        scope = next((at for _, at, other in self._flow.nodes if other is node), None)
        kinds = {type(value) for value in self._flow.constants(node, module, scope)} if node is not None else set()
        if kinds and kinds <= {int, float}:
            return "float"
        if len(kinds) == 1 and kinds <= {bool, str}:
            return "bool" if bool in kinds else "str"
        if node is not None and (isinstance(node, ast.BinOp) or unit_of(last_name(node))):
            return "float"
        return ""


def merged(before: Operation | None, operation: Operation) -> Operation:
    """Two uses of the same operation as one."""
    if before is None:
        return operation
    return replace(
        before,
        kind="method" if "method" in (before.kind, operation.kind) else "attribute",
        returns=before.returns or operation.returns,
        arguments=_better(before.arguments, operation.arguments),
        told=tuple(_common(*pair) for pair in zip_longest(before.told, operation.told, fillvalue="")),
        is_async=before.is_async or operation.is_async,
        is_set=before.is_set or operation.is_set,
        compared=tuple(dict.fromkeys(before.compared + operation.compared)),
        usual=one_of(before.usual, operation.usual),
        parts=before.parts or operation.parts,
    )


def _part(name: str) -> Part:
    """A part of which only the name is known; `_` is none."""
    is_number = bool(axis(name) or unit_of(name))
    return Part(name.strip("_"), "float" if is_number else "", "0.0" if is_number else "Anything()")


def _better(names: tuple[str, ...], others: tuple[str, ...]) -> tuple[str, ...]:
    """Of two lists of arguments the longer one, or the one that has more names."""

    def worth(some: tuple[str, ...]) -> tuple[int, int]:
        return len(some), sum(not name.startswith(ARGUMENT) for name in some)

    return max(names, others, key=worth)


def _common(kind: str, other: str) -> str:
    """The kind of what is told in two places; as a text, where these are two kinds."""
    return kind or other if not kind or not other or kind == other else "str"


ARGUMENT = "argument_"


def argument_names(call: ast.Call) -> tuple[str, ...]:
    """What the arguments of a call are called: as what is handed over, or by their numbers; none twice."""
    names = [last_name(argument).strip("_") for argument in call.args]
    names += [keyword.arg.strip("_") for keyword in call.keywords if keyword.arg]
    taken = [name for name in names if names.count(name) > 1 or not name.isidentifier() or iskeyword(name)]
    return tuple(
        f"{ARGUMENT}{number}" if name in taken or name == "self" else name for number, name in enumerate(names, 1)
    )
