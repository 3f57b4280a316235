"""Skimming: when only generated tests are wanted, files that cannot have any are not imported.

A project may have thousands of other tests, and importing them takes longer than learning a suite. A file's source
decides, so every worker decides alike: its text, and where that leaves a doubt, what is defined and imported in it. In
doubt still, a file is collected as ever: where a test, a class or a fixture that asks for `hri_case` may come from
elsewhere.
"""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator, Sequence
from fnmatch import fnmatch
from pathlib import Path

CASE = "hri_case"
_KEPT = ("__init__.py", "conftest.py")
_HOOKS = ("pytest_generate_tests", "pytest_plugins")

# What a file must have in its text to have tests from elsewhere: quicker than to parse all files.
_SUSPICIOUS = re.compile(
    r"\bimport\s*\*|^\s*class\s+\w+\s*\(\s*\w|\bimport\b[^\n]*\b[Tt]est\w*\s*(?:,|\)|#|$)|^\s+[Tt]est\w*\s*,?\s*$"
    r"|^[Tt]est\w*\s*=|" + "|".join(_HOOKS),
    re.MULTILINE,
)


class Skimming:
    """Tells files that cannot have generated tests by their source.

    Args:
        names: what the names of tests and of their classes begin with, or globs (ini `python_functions` and
            `python_classes`).
    """

    def __init__(self, names: Sequence[str]) -> None:
        self._names = names
        self._wrapped = False

    def look_at(self, plugin: object) -> None:
        """Look at a plugin, or a conftest.py, for a fixture that asks for the case: then any file may use that.

        pytest loads the conftest.py of a folder before it looks at the folder's files.
        """
        names = {**vars(type(plugin)), **getattr(plugin, "__dict__", {})}
        self._wrapped = self._wrapped or any(CASE in _asks_for(value) for value in names.values())

    def is_without_cases(self, path: Path) -> bool:
        """Whether a file that pytest is about to collect can be left out."""
        if self._wrapped or path.suffix != ".py" or path.name in _KEPT:
            return False
        try:
            text = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError):
            return False  # what pytest says of it is clearer
        if CASE not in text and _SUSPICIOUS.search(text) is None and self._names_are_usual:
            return True
        try:
            tree = ast.parse(text)
        except (SyntaxError, ValueError):
            return False  # what pytest says of it is clearer
        return not (any(map(_asks, ast.walk(tree))) or any(map(self._may_be_from_elsewhere, _outside_functions(tree))))

    @property
    def _names_are_usual(self) -> bool:
        """Whether a text without suspicion has no test from elsewhere: else the names of tests are others."""
        return {*self._names} <= {"test", "Test"}

    def _may_be_from_elsewhere(self, node: ast.AST) -> bool:
        """Whether a statement gives the file a test, a test's class, or a hook that is not written out in it."""
        match node:
            case ast.ImportFrom(names=names) | ast.Import(names=names):
                return any(each.name == "*" or self._is_test(each.asname or each.name) for each in names)
            case ast.ClassDef(name=name, bases=bases):
                return bool(bases) and self._is_test(name)
            case ast.Name(id=name, ctx=ast.Store()):
                return name in _HOOKS or self._is_test(name)
            case ast.FunctionDef(name=name):
                return name in _HOOKS
        return False

    def _is_test(self, name: str) -> bool:
        return any(name.startswith(each) or fnmatch(name, each) for each in self._names)


def _asks(node: ast.AST) -> bool:
    """Whether a test or a fixture asks for the case: as an argument, or by its name in a mark or a request."""
    return (isinstance(node, ast.arg) and node.arg == CASE) or (isinstance(node, ast.Constant) and node.value == CASE)


def _outside_functions(node: ast.AST) -> Iterator[ast.AST]:
    for child in ast.iter_child_nodes(node):
        yield child
        if not isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            yield from _outside_functions(child)


def _asks_for(value: object) -> tuple[str, ...]:
    """The names of a fixture's arguments; nothing for what is no fixture: these wrap their function."""
    if not hasattr(value, "__wrapped__") or not callable(value):
        return ()
    try:
        return tuple(inspect.signature(value).parameters)
    except (TypeError, ValueError):
        return ()
