"""Branches of functions that depend on a value: what runs where it is one of several texts."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator

from pytest_hricdv.extra.draft.code.flow import Flow, texts
from pytest_hricdv.extra.draft.code.sources import Scope


class Branches:
    """Finds the statements that do not run for a text.

    Args:
        flow: of the code.
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
                    known, is_not = self._read_test(part, scope, names)
                    if known and is_not:
                        yield known, node.orelse, node.body
                    elif known:
                        yield known, node.body, [] if isinstance(node.test, ast.BoolOp) else node.orelse
            elif isinstance(node, ast.Match) and ast.unparse(node.subject) in names:
                for case in node.cases:
                    parts = [each.value for each in ast.walk(case.pattern) if isinstance(each, ast.MatchValue)]
                    known = {text for part in parts for text in self._texts(part, scope)}
                    if known:
                        yield known, case.body, []

    def _read_test(self, test: ast.expr, scope: Scope, names: set[str]) -> tuple[set[str], bool]:
        if not isinstance(test, ast.Compare) or len(test.ops) != 1:
            return set(), False
        sides = [test.left, test.comparators[0]]
        others = [side for side in sides if ast.unparse(side) not in names]
        known = {text for side in others for text in self._texts(side, scope)} if len(others) == 1 else set()
        return known, isinstance(test.ops[0], ast.NotEq | ast.IsNot | ast.NotIn)

    def _texts(self, node: ast.expr, scope: Scope) -> set[str]:
        return set(texts(self._flow.constants(node, scope.module, scope)))
