"""Code under test of one module, from text."""

from __future__ import annotations

import textwrap
from pathlib import Path

import pytest

from pytest_hricdv.coverage.code_map import CodeMap, map_code
from pytest_hricdv.extra.mutation.mutants import Mutant, all_mutants

MODULE = "robot_under_test"


def code_of(text: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> CodeMap:
    """The map of a module with this text."""
    monkeypatch.syspath_prepend(folder)
    (folder / f"{MODULE}.py").write_text(textwrap.dedent(text), encoding="utf-8")
    return map_code((MODULE,), folder)


def mutants_of(text: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Mutant, ...]:
    """All mutants of a module with this text."""
    return all_mutants(code_of(text, folder, monkeypatch))
