"""Which names of the code under test the stand-ins replace."""

from __future__ import annotations

import concurrent.futures
import threading

import pytest

from pytest_hricdv.runtime.virtual import locks
from pytest_hricdv.runtime.virtual.modules import Replacements


class Hook:
    """Of a size like any other object's, so that the next one gets the place in memory that it leaves."""

    def __call__(self, arguments: object) -> None:
        """Nothing."""


def test_an_original_has_its_stand_in_and_nothing_else_has() -> None:
    replacements = Replacements()
    replacements.update()
    assert replacements.of(threading.Event) is locks.Event
    assert replacements.of(Hook) is Hook


def test_what_a_module_loads_when_it_is_asked_for_has_its_stand_in(monkeypatch: pytest.MonkeyPatch) -> None:
    """A library that has the pool by name is the first to ask for it."""
    monkeypatch.delitem(vars(concurrent.futures), "ThreadPoolExecutor", raising=False)
    replacements = Replacements()
    replacements.update()
    assert concurrent.futures.ThreadPoolExecutor in replacements
