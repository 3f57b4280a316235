"""Finds the lines of code that change a name of another module, as `json.dumps = None` does."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path


def places_of_change(names: Iterable[str], packages: Iterable[str]) -> tuple[str, ...]:
    """The lines, `file:line`, where packages set or delete an attribute or item of such a name, or pass its text.

    Args:
        names: the changed names, with their modules.
        packages: names of modules, and of packages with all of their loaded modules.
    """
    # The key of an item: sys.modules['json.decoder'].
    lasts = {name[:-2].rpartition("['")[2] if name.endswith("']") else name.rpartition(".")[2] for name in names}
    roots = tuple(packages)
    found: list[str] = []
    for name, module in [*sys.modules.items()]:
        file = getattr(module, "__file__", None)
        if not isinstance(file, str) or not any(name == root or name.startswith(f"{root}.") for root in roots):
            continue
        with suppress(OSError, SyntaxError, ValueError, RecursionError):
            found += [f"{file}:{line}" for line in _lines(ast.parse(Path(file).read_bytes()), lasts)]
    return tuple(found)


def _lines(tree: ast.AST, names: set[str]) -> Iterator[int]:
    for node in ast.walk(tree):
        match node:
            case ast.Attribute(attr=name, ctx=ast.Store() | ast.Del(), lineno=line) if name in names:
                yield line
            case ast.Subscript(slice=ast.Constant(value=str(name)), ctx=ast.Store() | ast.Del()) if name in names:
                yield node.lineno  # vars(json)["dumps"] = None
            case ast.Call(func=ast.Name(id="setattr" | "delattr"), args=[_, ast.Constant(value=str(name)), *_]) if (
                name in names
            ):
                yield node.lineno
            case ast.Call(func=ast.Attribute(value=ast.Attribute(attr=name))) if name in names:
                yield node.lineno  # a list or dict that is changed in place: sys.meta_path.insert(...)
