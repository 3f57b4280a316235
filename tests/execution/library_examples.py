"""Instruments modules of the standard library and runs the examples of their docstrings."""

from __future__ import annotations

import ast
import doctest
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest

from pytest_hricdv.execution.instrumented_code import Change

LIBRARIES = ("collections", "difflib", "fractions", "statistics", "zipfile")


def failed_examples(name: str, change: Change, monkeypatch: pytest.MonkeyPatch) -> int:
    """How many examples of a module fail if its text is changed."""
    library = import_module(name)
    assert library.__file__ is not None
    tree = ast.fix_missing_locations(change(ast.parse(Path(library.__file__).read_text(encoding="utf-8"))))
    made = ModuleType(name)
    vars(made).update(
        {key: value for key, value in vars(library).items() if key in ("__file__", "__path__", "__spec__")}
    )
    monkeypatch.setitem(sys.modules, name, made)
    exec(compile(tree, library.__file__, "exec", dont_inherit=True), vars(made))
    failed, attempted = doctest.testmod(made)
    assert attempted > 10
    return failed
