"""Stand-ins for modules that are not installed, as the libraries of a robot's hardware on a developer's machine."""

from __future__ import annotations

import sys
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

from pytest_hricdv.extra.draft.stand_ins.parts import exception_type, is_caught, part_of_module


class _AbsentModule(ModuleType):
    """A module that is not installed."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.__path__ = []  # so that it has submodules

    def __getattr__(self, name: str) -> Any:
        # It is kept: `except` needs the class that was raised.
        make = exception_type if is_caught(sys._getframe(1)) else part_of_module
        self.__dict__[name] = found = make(self.__name__.rpartition(".")[2], name)
        return found


class _AbsentFinder(MetaPathFinder, Loader):
    """Finds the modules that are not installed."""

    def __init__(self, names: frozenset[str]) -> None:
        self.names = names

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        """Find these modules, and those in them."""
        is_absent = any(f"{fullname}.".startswith(f"{name}.") for name in self.names)
        return ModuleSpec(fullname, self, is_package=True) if is_absent else None

    def create_module(self, spec: ModuleSpec) -> _AbsentModule:
        """A stand-in."""
        return _AbsentModule(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """There is nothing to execute."""


def replace_modules(*names: str) -> None:
    """Let code be imported without modules that are not installed: each gets a stand-in."""
    if not any(isinstance(finder, _AbsentFinder) and finder.names == {*names} for finder in sys.meta_path):
        sys.meta_path.insert(0, _AbsentFinder(frozenset(names)))
