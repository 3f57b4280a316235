"""Instrumented code does the same, and an import costs the same however many files are changed."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

from pytest_hricdv.execution.instrumented_code import instrument


class _CountingFinder:
    calls = 0

    def find_spec(self, fullname: str, path: Sequence[str] | None, target: object = None) -> None:
        """Find nothing."""
        self.calls += 1


def test_an_import_asks_a_finder_as_often_with_many_changed_files_as_with_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    finder = _CountingFinder()
    monkeypatch.setattr(sys, "meta_path", [finder])
    with instrument([(tmp_path / f"part{number}.py", "x = 1\n", lambda tree: tree) for number in range(24)], {}):
        assert find_spec("no_such_module_anywhere") is None
    assert finder.calls == 2  # once for the import, once for the finder of changed files
    assert sys.meta_path == [finder]


LAMBDAS = """
OPERATIONS = {"+": lambda a, b: a + b, "-": lambda a, b: a - b}
BOTH = (lambda a: [a], lambda a: {a}), lambda a: (lambda b: a + b, lambda b: a - b)
"""


def test_functions_of_one_line_stay_apart(tmp_path: Path) -> None:
    path = tmp_path / "lambdas.py"
    path.write_text(LAMBDAS, encoding="utf-8")
    spec = spec_from_file_location("lambdas", path)
    assert spec is not None
    assert spec.loader is not None
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    codes = [function.__code__ for function in module.OPERATIONS.values()]
    with instrument([(path, LAMBDAS, lambda tree: tree)], {}):
        assert all(
            function.__code__ is not code for function, code in zip(module.OPERATIONS.values(), codes, strict=True)
        )
        assert [calculate(5, 3) for calculate in module.OPERATIONS.values()] == [8, 2]
        (single, unique), nested = module.BOTH
        assert (single(1), unique(1), [inner(3) for inner in nested(5)]) == ([1], {1}, [8, 2])
    assert [function.__code__ for function in module.OPERATIONS.values()] == codes
