"""Changed code in a fork: what was imported, and what was not, does what the changed text says."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from pytest_hricdv.execution.forked import InFork, fork
from pytest_hricdv.extra.diagnosis.changed_code import put_in

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no forks")

TEXT = """\
LIMIT, NAME = 3, "robot"

def plain():
    return 1

class Robot:
    @property
    def speed(self):
        return 2 * LIMIT

    def makes(self):
        def inner():
            return self.speed
        return inner
"""
USER = "from robot_code import LIMIT, Robot, plain\n\ndef used():\n    return LIMIT\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """With two modules, which are forgotten afterwards."""
    (tmp_path / "robot_code.py").write_text(TEXT, encoding="utf-8")
    (tmp_path / "robot_user.py").write_text(USER, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    for name in ("robot_code", "robot_user"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    return tmp_path


def in_fork(folder: Path, old: str, new: str, look: Callable[[], object]) -> str:
    """What a fork sees that has other code."""
    assert old in TEXT
    process = fork()
    if isinstance(process, InFork):
        message = "nothing"
        try:
            message = f"{put_in(folder / 'robot_code.py', TEXT, TEXT.replace(old, new))} {look()}"
        finally:
            process.send_and_end(message.encode())
    try:
        return process.message().decode()
    finally:
        process.close()


@pytest.mark.parametrize("is_imported", [True, False])
@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("return 1", "return 7", "True (7, 6, 6, 3)"),
        ("2 * LIMIT", "5 * LIMIT", "True (1, 15, 15, 3)"),
        ("return self.speed", "return self.speed + 1", "True (1, 6, 7, 3)"),
        ("LIMIT, NAME = 3,", "LIMIT, NAME = 4,", "True (1, 8, 8, 4)"),
    ],
)
def test_code_that_was_imported_or_not_is_changed(
    folder: Path, is_imported: bool, old: str, new: str, expected: str
) -> None:
    if is_imported:
        importlib.import_module("robot_user")

    def look() -> object:
        user = importlib.import_module("robot_user")
        robot = user.Robot()
        return user.plain(), robot.speed, robot.makes()(), user.used()

    assert in_fork(folder, old, new, look) == expected
    assert importlib.import_module("robot_user").plain() == 1


def test_what_cannot_be_changed_is_said(folder: Path) -> None:
    importlib.import_module("robot_user")
    assert in_fork(folder, "class Robot:", "class Robot(dict):", lambda: "") == "False "
