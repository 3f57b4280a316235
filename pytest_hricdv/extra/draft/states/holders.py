"""Variables that hold the state of a robot: which they are, which states they have, and with which they begin."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.extra.draft.found.findings import Place
from pytest_hricdv.extra.draft.reading.constants import Member, is_enum, members
from pytest_hricdv.extra.draft.reading.sources import Module, Scope, Sources, dotted_name
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow

STATE_NAMES = ("state", "mode", "phase", "status", "stage", "current", "step")
"""A variable that has one of these in its name may hold a state, also where it is a text."""


@dataclass(frozen=True)
class Holder:
    """A variable that holds a state: an attribute of a class, or a local variable of a function."""

    attribute: str
    owner: ast.ClassDef | None
    function: ast.AST | None
    module: Module

    def is_it(self, node: ast.AST | None) -> bool:
        """Whether an expression is this variable."""
        if (
            isinstance(node, ast.Attribute)
            and node.attr in ("value", "name")
            and self.attribute not in ("value", "name")
        ):
            return self.is_it(node.value)
        if self.owner is not None:
            return isinstance(node, ast.Attribute) and node.attr == self.attribute and dotted_name(node.value) == "self"
        return isinstance(node, ast.Name) and node.id == self.attribute


def state_name(value: Any) -> str:
    """How a state is called that a constant names; empty where it names none."""
    if isinstance(value, Member):
        return value.text
    return value if isinstance(value, str) else ""


def initial_of_class(flow: ValueFlow, holder: Holder, sources: Sources) -> set[str]:
    if holder.owner is None:
        return set()
    for statement in holder.owner.body:
        if isinstance(statement, ast.AnnAssign | ast.Assign) and statement.value is not None:
            targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
            if any(isinstance(target, ast.Name) and target.id == holder.attribute for target in targets):
                return {state_name(value) for value in flow.constants(statement.value, holder.module, None)}
    return set()


def holders(sources: Sources, flow: ValueFlow) -> Iterator[tuple[Holder, dict[str, Place]]]:
    """Variables that hold a state: set to several constants, and tested, or named like one."""
    assigned: dict[tuple[str, int, int], list[tuple[Module, Scope, ast.expr]]] = defaultdict(list)
    for module, scope, node in flow.nodes:
        if not isinstance(node, ast.Assign | ast.AnnAssign) or scope is None or node.value is None:
            continue
        for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
            parts = [(target, node.value)]
            if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                parts = list(zip(target.elts, node.value.elts, strict=False))
            for part, value in parts:
                if isinstance(part, ast.Attribute) and dotted_name(part.value) == "self" and scope.owner is not None:
                    assigned[part.attr, id(scope.owner), 0].append((module, scope, value))
                elif isinstance(part, ast.Name):
                    assigned[part.id, 0, id(scope.node)].append((module, scope, value))
    for (name, owner, _), values in assigned.items():
        module, scope, _value = values[0]
        holder = Holder(name, scope.owner if owner else None, None if owner else scope.node, module)
        enum = enum_of(sources, flow, holder)
        is_named = any(part in name.lower() for part in STATE_NAMES)
        if enum is not None:
            states = {member.text: enum.module.place(where) for member, where in members(sources, enum)}
        else:
            states = {
                text: place
                for where, at, value in values
                for constant, place in flow.constants(value, where, at).items()
                if (text := state_name(constant))
            }
        tests = _tests(flow, holder)
        if len(states) > 1 and len(values) > 1 and (tests if enum is not None else is_named and tests):
            yield holder, states


def enum_of(sources: Sources, flow: ValueFlow, holder: Holder) -> Scope | None:
    names: set[str] = set()
    for module, scope, node in flow.nodes:
        if isinstance(node, ast.Assign) and scope is not None and module is holder.module:
            for target in node.targets:
                if (
                    holder.is_it(target)
                    and (holder.owner is None or scope.owner is holder.owner)
                    and (holder.function is None or scope.node is holder.function)
                ):
                    names |= {v.enum for v in flow.constants(node.value, module, scope) if isinstance(v, Member)}
    for scope in sources.classes:
        if scope.node.name in names and is_enum(sources, scope):
            return scope
    return None


def _tests(flow: ValueFlow, holder: Holder) -> int:
    """How often a variable is tested, matched, or looked up."""
    count = 0
    for module, scope, node in flow.nodes:
        if module is not holder.module or scope is None:
            continue
        if scope.owner is not holder.owner and scope.node is not holder.function:
            continue
        if isinstance(node, ast.Compare):
            count += any(holder.is_it(part) for part in (node.left, *node.comparators))
        elif isinstance(node, ast.Match):
            count += holder.is_it(node.subject) or any(holder.is_it(part) for part in ast.walk(node.subject))
        elif isinstance(node, ast.Subscript):
            count += holder.is_it(node.slice) or any(holder.is_it(part) for part in ast.walk(node.slice))
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "get":
            count += any(holder.is_it(part) for part in node.args)
        elif isinstance(node, ast.JoinedStr):
            count += any(holder.is_it(part) for part in ast.walk(node))
    return count
