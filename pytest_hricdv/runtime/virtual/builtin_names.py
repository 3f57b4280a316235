"""Python's own functions and classes stay what they are while code under test runs, or is imported for it.

`builtins.zip = None` would hold for the kernel, for the monitors and for pytest as well, from this line on, and what
fails then has nothing to do with it. So the assignment itself is refused, with its line.
"""

from __future__ import annotations

import builtins
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import Any

from pytest_hricdv.runtime.source_location import place_of
from pytest_hricdv.runtime.virtual.real_time import ProhibitedError

# Names that libraries replace, as `rich` does with `print`: the session uses none of these, and restores them
# afterwards.
_REPLACEABLE = {"__import__", "breakpoint", "copyright", "credits", "exit", "help", "input", "license", "open", "print"}
_NAMES = frozenset(vars(builtins)) - _REPLACEABLE - {"_", "quit", "__doc__", "__loader__", "__spec__"}


class _Builtins(ModuleType):
    """The module `builtins`, of which names can be added and no other be changed."""

    def __setattr__(self, name: str, value: Any) -> None:
        if vars(builtins).get(name) is not value:
            _refuse(name)
        super().__setattr__(name, value)

    def __delattr__(self, name: str) -> None:
        _refuse(name)
        super().__delattr__(name)


@contextmanager
def keep_builtins() -> Iterator[None]:
    """Refuse to replace what everybody uses. Raises ProhibitedError if somebody does."""
    before = builtins.__class__
    builtins.__class__ = _Builtins
    try:
        yield
    finally:
        builtins.__class__ = before


def _refuse(name: str) -> None:
    if name in _NAMES:
        raise ProhibitedError(
            f"{place_of(sys._getframe(2))}: builtins.{name} is changed for the whole process, pytest included: change "
            "it in the code's own modules only"
        )
