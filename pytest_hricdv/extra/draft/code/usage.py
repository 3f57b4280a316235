"""How demos, tests and main programs use the code: the calls that they repeat, without running them."""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from pytest_hricdv.extra.draft.code.sources import Sources, name_with_dots

USERS = ("test*.py", "tests/**/*.py", "test/**/*.py", "demo*.py", "demos/**/*.py", "main*.py", "example*.py",
         "examples/**/*.py", "run*.py", "scripts/**/*.py", "__main__.py")  # fmt: skip
"""Patterns of programs that use the code."""

MAX_FILES, MAX_BYTES = 100, 200_000
"""More files, and longer ones, are not read."""


def read_calls(sources: Sources) -> Counter[str]:
    """Calls of programs, next to the code or in it -> how many of them are in loops, and pass no text."""
    calls: Counter[str] = Counter()
    read = {module.file for module in sources.modules}
    roots = [sources.root, *(sources.root / name for name in sources.top_level), sources.root.parent]
    files = dict.fromkeys(path for root in roots if root.is_dir() for path in _files(root, sources.root))
    for path in list(files)[:MAX_FILES]:
        if path.is_relative_to(sources.root) and path.relative_to(sources.root).as_posix() in read:
            continue
        try:
            tree = ast.parse(path.read_bytes())
        except (SyntaxError, ValueError, OSError, RecursionError):
            continue
        calls.update(_calls(tree))
    for module in sources.modules:  # `if __name__ == "__main__":`
        for statement in module.tree.body:
            if isinstance(statement, ast.If) and "__name__" in ast.unparse(statement.test):
                calls.update(_calls(statement))
    return calls


def _files(root: Path, code: Path) -> Iterator[Path]:
    patterns = USERS if root != code.parent else USERS[1:3]  # `tests/` beside `src/`
    for pattern in patterns:
        for path in sorted(root.glob(pattern)):
            if path.is_file() and path.stat().st_size <= MAX_BYTES:
                yield path


def _calls(node: ast.AST) -> Counter[str]:
    """The last part of what is called, but for functions of modules, such as `time.sleep`."""
    modules = {alias.asname or alias.name.partition(".")[0]
               for each in ast.walk(node) if isinstance(each, ast.Import) for alias in each.names}  # fmt: skip
    calls: Counter[str] = Counter()
    waiting: list[tuple[ast.AST, int]] = [(node, 0)]
    while waiting:
        each, depth = waiting.pop()
        inner = 0 if isinstance(each, ast.If) else depth + isinstance(each, ast.For | ast.While | ast.AsyncFor)
        waiting += [(child, inner) for child in ast.iter_child_nodes(each)]
        if isinstance(each, ast.Call):
            owner, _, name = name_with_dots(each.func).rpartition(".")
            passed = (*each.args, *(keyword.value for keyword in each.keywords))
            has_texts = any(isinstance(getattr(value, "value", None), str) for value in passed)
            if owner not in modules or name[:1].isupper():
                calls[name or getattr(each.func, "attr", "")] += depth > 0 and not has_texts
    return calls
