"""`instrument` changes functions of the code under test so that they call hooks, in this process only.

Existing functions are changed in place; modules imported later are changed when they are loaded. Line numbers stay, so
tracebacks and coverage refer to the unchanged file. `schedules.scheduler` uses it to control the order of nodes, and
`diagnosis.switching` to reverse decisions of the code.
"""

from __future__ import annotations

import ast
import builtins
import gc
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

from pytest_hricdv.execution.faulty_import import FaultyImport

Change = Callable[[ast.Module], ast.Module]
"""Changes the syntax tree of a file. Inserted nodes have the location of the node that follows them."""


@contextmanager
def instrument(
    files: Iterable[tuple[Path, str, Change]],
    hooks: Mapping[str, Callable[..., Any]],
    functions: Sequence[FunctionType] | None = None,
) -> Iterator[None]:
    """Change functions of files for a while.

    Args:
        files: the path, the text and the change of each file. A file that does not compile when changed is skipped.
        hooks: name -> the function that changed code calls by it; the names must not occur in the code.
        functions: the functions of these files if the caller has them from `find_functions`, as before a fork.
    """
    changed: list[tuple[FunctionType, CodeType]] = []
    trees: dict[Path, str | ast.Module] = {}
    vars(builtins).update(hooks)
    functions = find_functions() if functions is None else functions
    for path, text, change in files:
        try:
            tree = ast.fix_missing_locations(change(ast.parse(text)))
            made = compile(tree, str(path), "exec", dont_inherit=True)
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            continue
        changed += _replace(made, functions)
        trees[path] = tree
    finder = FaultyImport(trees)
    sys.meta_path.insert(0, finder)
    try:
        yield
    finally:
        for function, code in changed:
            function.__code__ = code
        sys.meta_path[:] = [other for other in sys.meta_path if other is not finder]
        # A module that was imported meanwhile goes on to call the hooks.


def find_functions(paths: Iterable[Path] | None = None) -> list[FunctionType]:
    """All existing functions of some files, or of all.

    It touches each object of the process, which in a fork copies all memory: call it before you fork.
    """
    names = None if paths is None else frozenset(map(str, paths))
    # Objects frozen for forks are hidden from the collector, so they are thawed meanwhile.
    is_frozen = gc.get_freeze_count() > 0
    if is_frozen:
        gc.unfreeze()
    try:
        functions = [function for function in gc.get_objects() if type(function) is FunctionType]
        return [candidate for candidate in functions if names is None or candidate.__code__.co_filename in names]
    finally:
        if is_frozen:
            gc.freeze()


def _replace(made: CodeType, functions: Iterable[FunctionType]) -> Iterator[tuple[FunctionType, CodeType]]:
    codes = {_position(code): code for code in _codes(made)}
    for function in functions:
        old = function.__code__
        if old.co_filename == made.co_filename:
            new = codes.get(_position(old))
            if new is not None and new.co_freevars == old.co_freevars:
                function.__code__ = new
                yield function, old


def _position(code: CodeType) -> tuple[str, int, int]:
    """What tells the functions of a file apart: of lambdas in one line, the column of the first expression, too."""
    first = 0
    if code.co_name == "<lambda>":
        first = min(
            (column for line, _, column, _ in code.co_positions() if line == code.co_firstlineno and column), default=0
        )
    return code.co_qualname, code.co_firstlineno, first


def _codes(code: CodeType) -> Iterator[CodeType]:
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)
