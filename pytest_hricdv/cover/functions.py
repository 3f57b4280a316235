"""The functions of a source file, so that a line can be told by the function that it is in."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass


@dataclass(frozen=True)
class Function:
    """A function, or the module itself: its name as in `Robot.move`, and the lines of its body."""

    name: str
    first: int
    last: int

    def __contains__(self, line: int) -> bool:
        return self.first <= line <= self.last


MODULE = "the module"


def functions(source: str) -> tuple[Function, ...]:
    """All functions, inner ones before those around them, and the module last. Of no Python: the module."""
    lines = source.count("\n") + 1
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError):
        tree = ast.Module([], [])
    found = sorted(_found(tree, ""), key=lambda function: (function.last - function.first, function.first))
    return (*found, Function(MODULE, 1, max(lines, 1)))


def _found(node: ast.AST, prefix: str) -> Iterator[Function]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef):
            yield Function(f"{prefix}{child.name}", child.body[0].lineno, child.end_lineno or child.lineno)
        named = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
        yield from _found(child, f"{prefix}{child.name}." if named else prefix)  # type: ignore[attr-defined]
