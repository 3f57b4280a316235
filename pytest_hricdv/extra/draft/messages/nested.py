"""Messages within messages: classes of the code that a field of a message is, or has, instances of."""

from __future__ import annotations

import ast
from dataclasses import dataclass

from pytest_hricdv.extra.draft.reading.classes import form_of
from pytest_hricdv.extra.draft.reading.sources import Module, Scope, Sources, dotted_name

MADE = ("dataclass", "namedtuple", "typeddict", "model")
"""Forms of classes that are made by naming their fields."""

EMPTY = {"list": "[]", "List": "[]", "Sequence": "[]", "tuple": "()", "Tuple": "()", "Optional": "None"}


@dataclass(frozen=True)
class Inner:
    """A class within a field; `empty` is the source text of none of its instances, where there may be none."""

    scope: Scope
    empty: str = ""

    @property
    def name(self) -> str:
        """Of the class."""
        assert isinstance(self.scope.node, ast.ClassDef)
        return self.scope.node.name


def within(sources: Sources, module: Module, annotation: ast.expr | None) -> Inner | None:
    """The class of `Stop`, `"Stop"`, `list[Stop]`, `tuple[Stop, ...]`, `Stop | None`; None for other annotations."""
    if isinstance(annotation, ast.Constant) and isinstance(annotation.value, str):
        try:
            return within(sources, module, ast.parse(annotation.value, mode="eval").body)
        except SyntaxError:
            return None
    if isinstance(annotation, ast.BinOp) and isinstance(annotation.op, ast.BitOr):
        sides = [annotation.left, annotation.right]
        others = [side for side in sides if not (isinstance(side, ast.Constant) and side.value is None)]
        return _one(sources, module, others[0], "None") if len(others) == 1 else None
    if isinstance(annotation, ast.Subscript):
        parts = annotation.slice.elts if isinstance(annotation.slice, ast.Tuple) else [annotation.slice]
        empty = EMPTY.get(dotted_name(annotation.value).rpartition(".")[2], "")
        is_any = len(parts) == 1 if empty != "()" else len(parts) == 2 and ast.unparse(parts[1]) == "..."
        return _one(sources, module, parts[0], empty) if empty and is_any else None
    return _one(sources, module, annotation, "")


def _one(sources: Sources, module: Module, annotation: ast.expr | None, empty: str) -> Inner | None:
    own = sources.class_of(module, annotation)
    return Inner(own, empty) if own is not None and form_of(sources, own) in MADE else None
