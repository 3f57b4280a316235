"""Which imports are public, as docs/public-api.md lists them, and what their docstrings are."""

from __future__ import annotations

import ast
import re
from collections.abc import Sequence
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from studies.site.pages import DOCS

PAGE = DOCS / "public-api.md"
_ROW = re.compile(r"^\| \[`(?P<module>pytest_hricdv[\w.]*)`\]\((?P<page>\S+)\) \|[^|]*\| (?P<names>[^|]*) \|$", re.M)


def listed() -> dict[str, tuple[str, ...]]:
    """Module -> its public names, in the order of the page."""
    rows = _ROW.finditer(PAGE.read_text(encoding="utf-8"))
    return {row["module"]: tuple(re.findall(r"`(\w+)`", row["names"])) for row in rows}


def pages() -> dict[str, str]:
    """Module -> the page of its API, relative to docs/."""
    rows = _ROW.finditer(PAGE.read_text(encoding="utf-8"))
    return {row["module"]: row["page"] for row in rows}


def home(module: str, name: str) -> tuple[str, Sequence[ast.stmt]]:
    """The module that defines a name which `module` has, and there its definition, with the statement below it.

    Raises:
        LookupError: it is not defined where the imports lead.
    """
    body = _parsed(module).body
    for statement in body:
        if isinstance(statement, ast.ImportFrom) and name in {alias.name for alias in statement.names}:
            return home(str(statement.module), name)
    for number in reversed(range(len(body))):  # a function's overloads are above it
        if name in _defined(body[number]):
            return module, body[number : number + 2]
    raise LookupError(f"{module} neither defines nor imports {name}")


def docstring(module: str, name: str) -> str:
    """What the source says of a name, also of a value or an alias: the text below its definition. Empty if nothing."""
    _, (definition, *below) = home(module, name)
    if isinstance(definition, ast.ClassDef | ast.FunctionDef):
        return ast.get_docstring(definition) or ""
    match below:
        case [ast.Expr(value=ast.Constant(value=str(text)))]:
            return text
    return ""


def _defined(statement: ast.stmt) -> set[str]:
    match statement:
        case ast.ClassDef(name=name) | ast.FunctionDef(name=name):
            return {name}
        case ast.Assign(targets=targets):
            return {target.id for target in targets if isinstance(target, ast.Name)}
        case ast.AnnAssign(target=ast.Name(id=name)):
            return {name}
    return set()


@cache
def _parsed(module: str) -> ast.Module:
    spec = find_spec(module)
    assert spec is not None, module
    assert spec.origin is not None, module
    return ast.parse(Path(spec.origin).read_text(encoding="utf-8"))
