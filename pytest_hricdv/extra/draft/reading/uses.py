"""What code does with a value that it reads: what it compares it with, and what that says of it."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, reduce

from pytest_hricdv.extra.draft.reading.naming import unit_of
from pytest_hricdv.extra.draft.reading.sources import Module, Scope, dotted_name
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow, last_name

MAX_NAMES = 3
"""So many names a value may have one after the other (chosen)."""

_NUMBERS = ("abs", "min", "max", "float", "round", "hypot", "sqrt")
"""Functions that take numbers."""

_SAME = ("abs", "min", "max", "float", "round")
"""Functions of which one compares the result as one would the number."""

_TESTS = (ast.If, ast.While, ast.IfExp, ast.BoolOp, ast.UnaryOp, ast.Assert)


@dataclass(frozen=True)
class Use:
    """One place of a value: the expression, what is around it, and whether the value got there under a name."""

    node: ast.AST
    parent: ast.AST | None
    is_named: bool


@dataclass(frozen=True)
class Uses:
    """All places of a value.

    Args:
        places: where it stands.
        compared: the numbers that it is compared with.
        usual: on which side of them it usually is: "low", "high", or empty.
    """

    places: tuple[Use, ...]
    compared: tuple[float, ...]
    usual: str

    def kind(self, name: str) -> str:
        """The kind of the value, by its uses and its name: "bool", "float", "text"; empty where they say none.

        What has got a name is a number where it is compared with one, and true or false where each use is a test.
        """
        direct = next((kind for use in self.places if not use.is_named and (kind := _kind(use))), "")
        if direct:
            return direct
        named = [use for use in self.places if use.is_named]
        if named and self.compared:
            return "float"
        if unit_of(name):
            return "float"
        if named and all(isinstance(use.parent, _TESTS) for use in named):
            return "bool"
        return "bool" if name.startswith(("is_", "has_")) or "_is_" in name else ""


def _kind(use: Use) -> str:
    parent = use.parent
    if isinstance(parent, ast.Compare):
        others = [part for part in (parent.left, *parent.comparators) if part is not use.node]
        if any(isinstance(part, ast.Constant) and isinstance(part.value, str) for part in others):
            return "text"
        is_none = any(isinstance(part, ast.Constant) and part.value is None for part in others)
        return "" if is_none else "float"
    is_negative = isinstance(parent, ast.UnaryOp) and isinstance(parent.op, ast.USub)
    if is_negative or isinstance(parent, ast.BinOp | ast.AugAssign):
        return "float"
    if isinstance(parent, _TESTS):
        return "bool"
    return "float" if isinstance(parent, ast.Call) and last_name(parent.func) in _NUMBERS else ""


class UseFinder:
    """Finds the uses of values."""

    def __init__(self, flow: ValueFlow) -> None:
        self._flow = flow

    @cached_property
    def parents(self) -> dict[int, ast.AST]:
        """What is around each node, by the identity of this."""
        return {id(child): node for _, _, node in self._flow.nodes for child in ast.iter_child_nodes(node)}

    @cached_property
    def _scopes(self) -> dict[int, Scope | None]:
        """The function around each node."""
        return {id(node): scope for _, scope, node in self._flow.nodes}

    def of(self, node: ast.AST, module: Module) -> Uses:
        """All uses of what a node is."""
        places = tuple(self._places(node, 0))
        numbers = dict.fromkeys(number for use in places for number in self._compared(use, module))
        return Uses(places, tuple(numbers), reduce(one_of, map(self._usual, places), ""))

    def _places(self, node: ast.AST, names: int) -> Iterator[Use]:
        """Where a value stands: as it is, as the least or greatest of some, and under the names that it gets."""
        parent = self.parents.get(id(node))
        yield Use(node, parent, names > 0)
        if isinstance(parent, ast.Call) and last_name(parent.func) in _SAME and parent.func is not node:
            yield from self._places(parent, max(names, 1))
        elif isinstance(parent, ast.Assign | ast.NamedExpr) and parent.value is node and names < MAX_NAMES:
            if isinstance(parent, ast.NamedExpr):  # it stands there itself, too
                yield from self._places(parent, names + 1)
            for target in parent.targets if isinstance(parent, ast.Assign) else [parent.target]:
                for load in self._loads(target):
                    yield from self._places(load, names + 1)

    def _loads(self, target: ast.expr) -> Iterator[ast.expr]:
        """Where a variable of a function, or an attribute of `self`, is read."""
        scope = self._scopes.get(id(target))
        if isinstance(target, ast.Name) and scope is not None:
            for node in ast.walk(scope.node):
                if isinstance(node, ast.Name) and node.id == target.id and isinstance(node.ctx, ast.Load):
                    yield node
        elif scope is not None and scope.owner is not None and dotted_name(target).startswith("self."):
            for node in ast.walk(scope.owner):
                if not isinstance(node, ast.Attribute) or not isinstance(node.ctx, ast.Load):
                    continue
                if dotted_name(node) == dotted_name(target):
                    yield node

    def _compared(self, use: Use, module: Module) -> Iterator[float]:
        """The numbers that a value is compared with where it stands."""
        if not isinstance(use.parent, ast.Compare):
            return
        scope = self._scopes.get(id(use.parent))
        for part in (use.parent.left, *use.parent.comparators):
            for value in self._flow.constants(part, module, scope) if part is not use.node else ():
                if isinstance(value, int | float) and not isinstance(value, bool):
                    yield float(value)

    def _usual(self, use: Use) -> str:
        """On which side of what a value is compared with it usually is: where an `if` is false, and a `while` true."""
        compare = use.parent
        if not isinstance(compare, ast.Compare) or not isinstance(compare.ops[0], ast.Lt | ast.LtE | ast.Gt | ast.GtE):
            return ""
        is_low = isinstance(compare.ops[0], ast.Lt | ast.LtE) == (compare.left is use.node)
        above: ast.AST | None = compare
        while isinstance(above, ast.Compare | ast.BoolOp | ast.UnaryOp):
            is_low ^= isinstance(above, ast.UnaryOp) and isinstance(above.op, ast.Not)
            above = self.parents.get(id(above))
        if not isinstance(above, ast.If | ast.IfExp | ast.While):
            return ""
        return "low" if is_low == isinstance(above, ast.While) else "high"


def one_of(side: str, other: str) -> str:
    """The side that two comparisons say is usual; empty where they contradict each other."""
    return side or other if not side or not other or side == other else ""
