"""How demos, tests and main programs use the code: what they make, call and pass, without running them."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pytest_hricdv.extra.draft.code.sources import Sources, name_with_dots

USERS = ("test*.py", "tests/**/*.py", "test/**/*.py", "demo*.py", "demos/**/*.py", "main*.py", "example*.py",
         "examples/**/*.py", "run*.py", "scripts/**/*.py", "__main__.py")  # fmt: skip
"""Where programs are that use code."""

MAX_FILES, MAX_BYTES = 100, 200_000
"""More files, and longer ones, are not read."""


@dataclass
class CallOfUser:
    """How programs call a name.

    Args:
        count: of the calls.
        in_loop: of them, those that each round of a loop makes.
        values: constants, by the number or the name of the parameter.
    """

    count: int = 0
    in_loop: int = 0
    values: dict[int | str, list[Any]] = field(default_factory=dict)


@dataclass
class Usage:
    """Calls of all programs, by the last part of the name that is called, and the constants in their dicts, by key."""

    calls: dict[str, CallOfUser] = field(default_factory=dict)
    keys: dict[str, list[Any]] = field(default_factory=dict)

    def of(self, name: str) -> CallOfUser:
        """How a name is called."""
        return self.calls.get(name, CallOfUser())

    def values(self, name: str, number: int, parameter: str) -> list[Any]:
        """The constants that are passed for a parameter."""
        values = self.of(name).values
        return [*values.get(number, ()), *values.get(parameter, ())]


def read_usage(sources: Sources) -> Usage:
    """Read the programs beside the code, and in it."""
    usage = Usage()
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
        _read(usage, tree, 0)
    for module in sources.modules:  # `if __name__ == "__main__":`
        for statement in module.tree.body:
            if isinstance(statement, ast.If) and "__name__" in ast.unparse(statement.test):
                _read(usage, statement, 0)
    return usage


def _files(root: Path, code: Path) -> Iterator[Path]:
    patterns = USERS if root != code.parent else USERS[1:3]  # `tests/` beside `src/`
    for pattern in patterns:
        for path in sorted(root.glob(pattern)):
            if path.is_file() and path.stat().st_size <= MAX_BYTES:
                yield path


def _read(usage: Usage, node: ast.AST, loops: int) -> None:
    modules = {alias.asname or alias.name.partition(".")[0]
               for each in ast.walk(node) if isinstance(each, ast.Import) for alias in each.names}  # fmt: skip
    waiting: list[tuple[ast.AST, int]] = [(node, loops)]
    while waiting:
        each, depth = waiting.pop()
        inner = 0 if isinstance(each, ast.If) else depth + isinstance(each, ast.For | ast.While | ast.AsyncFor)
        waiting += [(child, inner) for child in ast.iter_child_nodes(each)]
        if isinstance(each, ast.Dict):
            for key, value in zip(each.keys, each.values, strict=True):
                if isinstance(key, ast.Constant) and isinstance(key.value, str) and isinstance(value, ast.Constant):
                    usage.keys.setdefault(key.value, []).append(value.value)
        if not isinstance(each, ast.Call):
            continue
        dotted = name_with_dots(each.func)
        if (
            dotted.partition(".")[0] in modules
            and dotted.count(".") == 1
            and not dotted.partition(".")[2][:1].isupper()
        ):
            continue  # a function of a module, such as `time.sleep`
        call = usage.calls.setdefault(dotted.rpartition(".")[2] or getattr(each.func, "attr", ""), CallOfUser())
        call.count += 1
        call.in_loop += depth > 0
        named: list[tuple[int | str, ast.expr]] = [(k.arg, k.value) for k in each.keywords if k.arg]
        for keyword in each.keywords:  # what is made into a dict
            if keyword.arg and isinstance(keyword.value, ast.Constant):
                usage.keys.setdefault(keyword.arg, []).append(keyword.value.value)
        for place, argument in [*enumerate(each.args), *named]:
            try:
                call.values.setdefault(place, []).append(ast.literal_eval(argument))
            except (ValueError, TypeError, SyntaxError, RecursionError):
                continue
