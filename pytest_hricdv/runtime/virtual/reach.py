"""Finds the modules that the code under test reaches: virtual time applies to all of them, in whatever package."""

from __future__ import annotations

import sys
import weakref
from collections.abc import Iterator, Sequence, Set
from types import BuiltinFunctionType, FrameType, FunctionType, ModuleType

TOOLS = frozenset(
    {
        *("pytest_hricdv", "pytest", "_pytest", "pluggy", "xdist", "execnet", "coverage", "greenlet", "hypothesis"),
        *("msgspec", "lark", "jinja2", "pydevd", "_pydevd_bundle", "debugpy", "__main__"),
    }
)
"""Packages that run the tests: they need real time, and no node runs them."""

_OF_PYTHON = frozenset({"logging.handlers", "email.utils"})
"""Modules of Python's library that are always reached: their threads take part in the run, they read its clock."""

_NAMED = (type, FunctionType, BuiltinFunctionType)


def is_tool(frame: FrameType) -> bool:
    """Whether one of these packages executes a frame; not of a script, nor of what calls functions for the code."""
    root = str(frame.f_globals.get("__name__")).partition(".")[0]
    return root in TOOLS and root not in ("__main__", "pytest_hricdv")


def is_library_of_python(module: str) -> bool:
    """Whether a module is of Python's own library."""
    return module.partition(".")[0] in sys.stdlib_module_names


def is_module(value: object) -> bool:
    """Whether it is one. Not by `isinstance`, which asks for its class: libraries of cffi say that they are modules."""
    return issubclass(type(value), ModuleType)


def is_initializing(module: ModuleType) -> bool:
    """Whether a module is in the middle of its import."""
    return bool(getattr(vars(module).get("__spec__"), "_initializing", False))


class Reach:
    """The modules of the code under test, and those that they name, directly or through others.

    A module names another one by a module, a function, a class or an object among its globals. An installed package is
    reached as a whole, as such packages load their modules by name. Python's own library and the tools that run the
    tests are not followed.

    Args:
        packages: the packages of the code under test.
    """

    def __init__(self, packages: Sequence[str]) -> None:
        self.packages = tuple(packages)
        self._roots = {package.partition(".")[0] for package in packages}
        self._installed: set[str] = set()
        self._reached: set[str] = {*_OF_PYTHON}

    def __contains__(self, module: object) -> bool:
        if not isinstance(module, str):
            return False
        return module in self._reached or module.partition(".")[0] in self._installed or self.is_code(module)

    def lacks(self, module: str) -> bool:
        """Whether virtual time belongs to a module as soon as one that is reached imports it, and not yet."""
        return module not in self and _is_followed(module)

    def is_code(self, module: str) -> bool:
        """Whether a module is of the code under test."""
        return any(module == package or module.startswith(f"{package}.") for package in self.packages)

    def modules(self) -> dict[str, ModuleType]:
        """The loaded modules by name, the code under test first."""
        found: dict[str, ModuleType] = {}
        pending = [name for name in [*sys.modules] if name.partition(".")[0] in self._roots and self.is_code(name)]
        pending += sorted(self._reached)
        while pending:
            for name in pending:
                module = sys.modules.get(name)
                if name not in found and module is not None and is_module(module):
                    found[name] = module
                    self.add(_modules_of(module))
                    found = {**self._modules_of_files(name, module), **found}
            loaded = (name for name in [*sys.modules] if name.partition(".")[0] in self._installed)
            pending = [name for name in dict.fromkeys((*sorted(self._reached), *loaded)) if name not in found]
            pending = [name for name in pending if is_module(sys.modules.get(name))]
        return found

    def _modules_of_files(self, owner: str, module: ModuleType) -> dict[str, ModuleType]:
        """Modules that one of the project has and `sys.modules` has not, as those that it loads from a file."""
        found: dict[str, ModuleType] = {}
        is_installed = owner.partition(".")[0] in self._installed
        for other in () if is_installed else filter(is_module, [*vars(module).values()]):
            name = ModuleType.__getattribute__(other, "__dict__").get("__name__")
            if isinstance(name, str) and name not in sys.modules and _is_followed(name):
                found[name] = other
                self.add(_modules_of(other) | {name})
        return found

    def add(self, names: Set[str]) -> None:
        """A module that is reached names these modules, or has imported them."""
        for name in filter(_is_followed, names - self._reached):
            self._reached.add(name)
            if "-packages" in str(getattr(sys.modules.get(name), "__file__", None)):
                self._installed.add(name.partition(".")[0])


def _modules_of(module: ModuleType) -> frozenset[str]:
    named = _NAMED_IN.get(module)
    if named is None:
        named = frozenset(filter(_is_followed, _names_in(module)))
        if not is_initializing(module):
            _NAMED_IN[module] = named
    return named


_NAMED_IN: weakref.WeakKeyDictionary[ModuleType, frozenset[str]] = weakref.WeakKeyDictionary()
"""Module -> the modules that it names: globals of a module hardly ever come to name others."""


def _is_followed(module: str) -> bool:
    root = module.partition(".")[0]
    return root not in TOOLS and not is_library_of_python(module)


def _names_in(module: ModuleType) -> Iterator[str]:
    for value in [*vars(module).values()]:
        # Not isinstance, which asks the object for its class: a proxy would begin to load its target.
        if is_module(value):
            name = ModuleType.__getattribute__(value, "__dict__").get("__name__")
        elif issubclass(type(value), _NAMED):
            name = value.__module__
        else:
            name = type(value).__module__
        if isinstance(name, str):
            yield name
