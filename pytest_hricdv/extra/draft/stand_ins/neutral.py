"""Stand-ins for what is not known: values of unknown types, and modules that are not installed."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import FunctionType, ModuleType
from typing import Any, Self


class Neutral(float):
    """A neutral value of an unknown type: 0.0, which has each attribute, can be called, and is empty."""

    def __new__(cls, *_: Any, **__: Any) -> Self:
        return float.__new__(cls)

    def __init__(self, *_: Any, **named: Any) -> None:
        self.__dict__.update(named)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return Neutral()

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Neutral; a decorator leaves a function as it is."""
        is_decorator = len(arguments) == 1 and not named and isinstance(arguments[0], FunctionType)
        return arguments[0] if is_decorator else Neutral()

    def __await__(self) -> Iterator[Any]:
        return iter(())

    def __getitem__(self, _: Any) -> Any:
        return Neutral()

    def __setitem__(self, _: Any, __: Any) -> None:
        return None

    def __contains__(self, _: Any) -> bool:
        return False

    def __iter__(self) -> Iterator[Any]:
        return iter(())

    def __len__(self) -> int:
        return 0

    def __index__(self) -> int:
        return 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        return None

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        return None

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> Any:
        raise StopAsyncIteration


class NeutralNumber(Neutral):
    """A number that a device returns; code that takes it for something else gets neutral values of it."""

    def __new__(cls, value: float) -> Self:
        return float.__new__(cls, value)

    def __init__(self, value: float) -> None:
        super().__init__()


class _ModuleStandIn(ModuleType):
    """A fake of a module that is not installed."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.__path__ = []  # so that it has submodules

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return type(name, (Neutral,), {}) if name[:1].isupper() and not name.isupper() else Neutral()


class _ModuleFinder(MetaPathFinder, Loader):
    """Finds the modules that are not installed, and hands out stand-ins."""

    def __init__(self, names: frozenset[str]) -> None:
        self.names = names

    def find_spec(self, fullname: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        """Find these modules only."""
        return ModuleSpec(fullname, self, is_package=True) if fullname.partition(".")[0] in self.names else None

    def create_module(self, spec: ModuleSpec) -> _ModuleStandIn:
        """A stand-in."""
        return _ModuleStandIn(spec.name)

    def exec_module(self, module: ModuleType) -> None:
        """There is nothing to execute."""


def replace_modules(*names: str) -> None:
    """Let code be imported without modules that are not installed: each gets a stand-in, of which nothing is known."""
    if not any(isinstance(finder, _ModuleFinder) and finder.names == {*names} for finder in sys.meta_path):
        sys.meta_path.insert(0, _ModuleFinder(frozenset(names)))
