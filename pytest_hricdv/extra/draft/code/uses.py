"""Uses of a value, which tell its kind if it is never compared."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from pytest_hricdv.extra.draft.code.flow import Flow, last_name
from pytest_hricdv.extra.draft.code.sources import Scope, name_with_dots

NUMBER_OF = ("int", "float", "round", "abs", "min", "max")
"""Functions that take numbers, or make them of texts."""

KIND_OF_USE = {"bool": "bool", "float": "float", "object": "", "text": "str", "any": "str"}
"""Kind of a value, by what is done with it."""


class UseReader:
    """Reads what is done with values."""

    def __init__(self, flow: Flow) -> None:
        self._flow = flow

    def kind(self, scope: Scope, name: str, skipped: frozenset[int] = frozenset()) -> str:
        """The kind of a value that nothing is compared with: by what is done with it; empty if it is an object."""
        kinds = {self._use(node) for node in walk_what_runs(scope.node, skipped)
                 if isinstance(node, ast.Name) and node.id == name and isinstance(node.ctx, ast.Load)}  # fmt: skip
        for node in ast.walk(scope.node):
            target = node.targets[0] if isinstance(node, ast.Assign) else None
            if isinstance(node, ast.Assign) and name_with_dots(node.value) == name and scope.owner is not None:
                kept = name_with_dots(target)
                kinds |= {self._use(each) for _, at, each in self._flow.nodes if isinstance(each, ast.Attribute)
                          and at is not None and at.owner is scope.owner and isinstance(each.ctx, ast.Load)
                          and name_with_dots(each) == kept}  # fmt: skip
        if not kinds or "object" in kinds:
            return ""  # nothing is done with it, or it has parts
        return "float" if "float" in kinds else "bool" if "bool" in kinds else "str"

    def kind_at(self, node: ast.AST) -> str:
        """The kind of a value by what is done with it where it stands."""
        return KIND_OF_USE[self._use(node)]

    def _use(self, node: ast.AST) -> str:
        above = self._flow.parents.get(id(node))
        if isinstance(above, ast.If | ast.While | ast.IfExp) and above.test is node:
            return "bool"
        if isinstance(above, ast.BoolOp) or (isinstance(above, ast.UnaryOp) and isinstance(above.op, ast.Not)):
            return "bool"
        if isinstance(above, ast.UnaryOp | ast.AugAssign):
            return "float"
        if isinstance(above, ast.BinOp):
            others = (above.left, above.right)
            is_text = any(isinstance(each, ast.JoinedStr) or isinstance(getattr(each, "value", None), str)
                          for each in others)  # fmt: skip
            return "text" if is_text else "float"
        if isinstance(above, ast.Call):
            is_object = above.func is node or last_name(above.func) in ("put", "put_nowait")
            return "object" if is_object else "float" if last_name(above.func) in NUMBER_OF else "any"
        is_inside = isinstance(above, ast.Attribute | ast.Starred | ast.For | ast.comprehension)
        is_inside |= isinstance(above, ast.Subscript) and above.value is node
        return "object" if is_inside or (isinstance(above, ast.keyword) and above.arg is None) else "any"


def find_identity_tests(flow: Flow) -> frozenset[str]:
    """Names of what the code tests as `button.is_pressed() is True`; no stand-in can see such a test."""
    found = set()
    for _, _, node in flow.nodes:
        if isinstance(node, ast.Compare) and isinstance(node.ops[0], ast.Is | ast.IsNot):
            other = node.comparators[0]
            if isinstance(other, ast.Constant) and isinstance(other.value, bool):
                found.add(last_name(node.left.func if isinstance(node.left, ast.Call) else node.left))
    return frozenset(found)


def walk_what_runs(node: ast.AST, skipped: frozenset[int]) -> Iterator[ast.AST]:
    """All nodes below one, without the skipped statements."""
    waiting = [node]
    while waiting:
        each = waiting.pop(0)
        yield each
        waiting += [child for child in ast.iter_child_nodes(each) if id(child) not in skipped]
