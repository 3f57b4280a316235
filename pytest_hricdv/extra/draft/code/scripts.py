"""Modules that are programs: what runs the robot is no function, but a loop among their statements."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence

from pytest_hricdv.extra.draft.code.flow import last_name
from pytest_hricdv.extra.draft.code.sources import Module, Sources
from pytest_hricdv.extra.draft.code_model import SCRIPT, Entry

GUARDED, IMPORTED = 2.0, 10.0
"""How likely a program is the entry, beside functions and classes; nothing can import one that runs where it is."""


def find_scripts(sources: Sources) -> Iterator[tuple[Entry, float]]:
    """The programs among the modules, each with how likely it is the entry."""
    endless = {scope.node.name for scope in sources.functions if _find_loop(scope.node.body) is not None}
    for module in sources.modules:
        free = [each for each in module.tree.body if not _is_guard(each)]
        guarded = [each for each in module.tree.body if _is_guard(each)]
        loop = _find_loop(free) or _find_call(free, endless)
        if loop is not None:
            yield _entry(module, loop), IMPORTED
        elif (loop := _find_loop(guarded)) is not None:
            yield _entry(module, loop), GUARDED


def _entry(module: Module, node: ast.stmt) -> Entry:
    return Entry(module.name, SCRIPT, "", False, (), (), module.location(node))


def _is_guard(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.If) and "__name__" in ast.unparse(statement.test)


def _statements(body: Sequence[ast.stmt]) -> Iterator[ast.stmt]:
    """The statements that run when a body does, those in blocks as well."""
    for statement in body:
        yield statement
        if not isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            for name in ("body", "orelse", "finalbody"):
                yield from _statements(getattr(statement, name, []))


def _find_loop(body: Sequence[ast.stmt]) -> ast.stmt | None:
    return next((each for each in _statements(body) if isinstance(each, ast.While)), None)


def _find_call(body: Sequence[ast.stmt], endless: set[str]) -> ast.stmt | None:
    """A statement that calls a function with a loop: `main()`, `robot.run()`, `asyncio.run(main())`."""
    for statement in _statements(body):
        called = statement.value if isinstance(statement, ast.Expr) else None
        if any(
            isinstance(each, ast.Call) and last_name(each.func) in endless for each in ast.walk(called or ast.Pass())
        ):
            return statement
    return None
