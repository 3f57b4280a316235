"""Which names of the code under test the stand-ins replace."""

from __future__ import annotations

import concurrent.futures
import sys
import threading
import time
from types import ModuleType

import pytest

from pytest_hricdv.runtime.kernel import Kernel
from pytest_hricdv.runtime.virtual import VirtualModules, clocks
from pytest_hricdv.runtime.virtual.modules import Replacements
from pytest_hricdv.runtime.virtual.outside import guard_run


class Hook:
    """Of a size like any other object's, so that the next one gets the place in memory that it leaves."""

    def __call__(self, arguments: object) -> None:
        """Nothing."""


def test_an_original_has_its_stand_in_and_nothing_else_has() -> None:
    replacements = Replacements()
    replacements.update()
    assert replacements.of(time.sleep) is clocks.sleep
    assert replacements.of(Hook) is Hook


def test_what_a_module_loads_when_it_is_asked_for_has_its_stand_in(monkeypatch: pytest.MonkeyPatch) -> None:
    """A library that has the pool by name is the first to ask for it."""
    monkeypatch.delitem(vars(concurrent.futures), "ThreadPoolExecutor", raising=False)
    replacements = Replacements()
    replacements.update()
    assert concurrent.futures.ThreadPoolExecutor in replacements


def test_what_takes_the_place_in_memory_of_a_hook_that_is_gone_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    replacements = Replacements()
    with monkeypatch.context() as patch:
        patch.setattr(threading, "excepthook", Hook())  # pytest sets one for each session
        replacements.update()
    others = [Hook() for _ in range(1000)]
    assert all(replacements.of(other) is other for other in others)


class Pretender:
    """Says that it is a module, as libraries of cffi do, and can have no weak references."""

    __slots__ = ()
    __class__ = ModuleType  # type: ignore[assignment]


def test_what_only_says_that_it_is_a_module_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pretender", Pretender())
    with VirtualModules(["pretender", __name__]).install(), guard_run(Kernel()):
        assert isinstance(sys.modules["pretender"], ModuleType)
