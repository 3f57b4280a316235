"""Infers the kind of a value from how the code uses it: as a condition, a number or a string (`kind_of_use`).

`ContentReader` calls it, and asks `Branches` which statements do not run if a value is a certain text.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator

from pytest_hricdv.extra.draft.code.flow import Flow, last_name, texts
from pytest_hricdv.extra.draft.code.sources import Scope

NUMBER_OF = ("int", "float", "round", "abs", "min", "max")
"""Functions whose arguments are numbers, or texts of numbers."""


def kind_of_use(flow: Flow, node: ast.AST) -> str:
    """The kind of a value by what is done with it: "bool", "float", "str"; empty for an object, or if runs show it."""
    above = flow.parents.get(id(node))
    if isinstance(above, ast.Assign) and all(
        isinstance(target, ast.Attribute | ast.Subscript) for target in above.targets
    ):
        return ""
    if isinstance(above, ast.Compare) and isinstance(above.ops[0], ast.Is | ast.IsNot):
        return ""
    is_condition = isinstance(above, ast.If | ast.While | ast.IfExp) and above.test is node
    is_not = isinstance(above, ast.UnaryOp) and isinstance(above.op, ast.Not)
    if is_condition or is_not or isinstance(above, ast.BoolOp):
        return "bool"
    if isinstance(above, ast.UnaryOp | ast.AugAssign):
        return "float"
    if isinstance(above, ast.BinOp):
        others = (above.left, above.right)
        is_text = any(isinstance(other, ast.JoinedStr) or isinstance(getattr(other, "value", None), str)
                      for other in others)  # fmt: skip
        return "str" if is_text else "float"
    if isinstance(above, ast.Call):
        is_object = above.func is node or last_name(above.func) in ("put", "put_nowait")
        return "" if is_object else "float" if last_name(above.func) in NUMBER_OF else "str"
    is_inside = isinstance(above, ast.Attribute | ast.Starred | ast.For | ast.AsyncFor | ast.comprehension)
    is_inside |= isinstance(above, ast.Subscript) and above.value is node
    return "" if is_inside or (isinstance(above, ast.keyword) and above.arg is None) else "str"


def walk_what_runs(node: ast.AST, skipped: frozenset[int]) -> Iterator[ast.AST]:
    """All nodes below one, without the skipped statements."""
    waiting = [node]
    while waiting:
        node = waiting.pop(0)
        yield node
        waiting += [child for child in ast.iter_child_nodes(node) if id(child) not in skipped]


class Branches:
    """Finds the statements that do not run for a text.

    Args:
        places: expressions with the value, each with the function in which it stands.
    """

    def __init__(self, flow: Flow, places: Iterable[tuple[Scope, ast.AST]]) -> None:
        self._flow = flow
        self._tests = [test for scope, names in self._names(places) for test in self._tests_in(scope, names)]

    def find_skips(self, text: str) -> frozenset[int]:
        """Identities of the statements that do not run for a text."""
        return frozenset(id(statement) for known, body, others in self._tests
                         for statement in (others if text in known else body))  # fmt: skip

    def _names(self, places: Iterable[tuple[Scope, ast.AST]]) -> Iterator[tuple[Scope, set[str]]]:
        """Each function with the source texts under which it has the value."""
        by_scope: dict[int, tuple[Scope, set[str]]] = {}
        for scope, node in places:
            names = by_scope.setdefault(id(scope.node), (scope, set()))[1]
            names.add(ast.unparse(node))
            above = self._flow.parents.get(id(node))
            targets = above.targets if isinstance(above, ast.Assign) else []
            targets = [above.target] if isinstance(above, ast.NamedExpr) else targets
            names |= {target.id for target in targets if isinstance(target, ast.Name)}
        yield from by_scope.values()

    def _tests_in(self, scope: Scope, names: set[str]) -> Iterator[tuple[set[str], list[ast.stmt], list[ast.stmt]]]:
        """Texts of each test, the statements for them, and those for all others."""
        for node in ast.walk(scope.node):
            if isinstance(node, ast.If):
                parts = node.test.values if isinstance(node.test, ast.BoolOp) else [node.test]
                for part in parts:
                    tested, is_not = self._read_test(part, scope, names)
                    if tested and is_not:
                        yield tested, node.orelse, node.body
                    elif tested:
                        yield tested, node.body, [] if isinstance(node.test, ast.BoolOp) else node.orelse
            elif isinstance(node, ast.Match) and ast.unparse(node.subject) in names:
                for case in node.cases:
                    parts = [part.value for part in ast.walk(case.pattern) if isinstance(part, ast.MatchValue)]
                    tested = {text for part in parts for text in self._texts(part, scope)}
                    if tested:
                        yield tested, case.body, []

    def _read_test(self, test: ast.expr, scope: Scope, names: set[str]) -> tuple[set[str], bool]:
        if not isinstance(test, ast.Compare) or len(test.ops) != 1:
            return set(), False
        sides = [test.left, test.comparators[0]]
        others = [side for side in sides if ast.unparse(side) not in names]
        tested = {text for side in others for text in self._texts(side, scope)} if len(others) == 1 else set()
        return tested, isinstance(test.ops[0], ast.NotEq | ast.IsNot | ast.NotIn)

    def _texts(self, node: ast.expr, scope: Scope) -> set[str]:
        return set(texts(self._flow.constants(node, scope.module, scope)))
