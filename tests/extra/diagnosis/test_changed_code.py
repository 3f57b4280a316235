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
from dataclasses import dataclass, field

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

@dataclass(frozen=True)
class Settings:
    near_m: float = 0.5
    far_m: float = field(default=2.0, kw_only=True)

@dataclass(frozen=True, slots=True)
class Slow(Settings):
    slow_m_s: float = 0.1
    late_s: float = 7.0

class Plain:
    near_m = 0.5
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


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("near_m: float = 0.5", "near_m: float = 0.9", "True 0.9 0.9 0.5 0.9 0.9 0.1 0.5"),
        ("slow_m_s: float = 0.1", "slow_m_s: float = 0.9", "True 0.5 0.5 0.5 0.5 0.5 0.9 0.5"),
        ("near_m = 0.5", "near_m = 0.9", "True 0.5 0.5 0.5 0.5 0.5 0.1 0.9"),
    ],
)
def test_constants_of_classes_are_changed_with_what_was_made_with_them(
    folder: Path, old: str, new: str, expected: str
) -> None:
    code = importlib.import_module("robot_code")
    made, given, slow = code.Settings(), code.Settings(float("0.5")), code.Slow()

    def look() -> str:
        after = [code.Settings().near_m, made.near_m, given.near_m, code.Slow().near_m, slow.near_m, slow.slow_m_s]
        return " ".join(map(str, [*after, code.Plain().near_m]))

    assert in_fork(folder, old, new, look) == expected
    assert code.Settings().near_m == code.Plain.near_m == 0.5


def test_what_cannot_be_changed_is_said(folder: Path) -> None:
    importlib.import_module("robot_user")
    assert in_fork(folder, "class Robot:", "class Robot(dict):", lambda: "") == "False "
