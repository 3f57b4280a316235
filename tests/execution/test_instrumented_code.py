"""Instrumented code: an import costs the same however many files are changed."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.util import find_spec
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
