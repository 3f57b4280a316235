"""While a run goes on, modules of Python's library stand for others in the modules under test, and nowhere else.

Code that is brought as it is sleeps with `time.sleep`, reads `datetime.now`, waits for events and queues of other
threads, or runs an event loop. In a simulated run these would wait in real time, in silence, or make each run another
one. The stand-ins wait in virtual time, or refuse where the testbench did not ask for it. Outside of nodes they are the
real ones as far as that makes sense: a module may ask for the time when it is imported.
"""

from __future__ import annotations

import builtins
import importlib
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from types import FunctionType, ModuleType
from typing import Any

from pytest_hricdv.runtime.virtual.keyboards import is_keyboard, refuse_in_nodes

_PROVIDERS = {
    "time": "clocks",
    "datetime": "clocks",
    "threading": "threads",
    "queue": "threads",
    "concurrent.futures": "thread_pool",
    "asyncio": "event_loop",
    "uuid": "clocks",
}
"""Module of the library -> the module here that has what stands for it."""

STAND_INS = tuple(f"{__package__}.{name}" for name in sorted({*_PROVIDERS.values()}))
"""The modules here that have what stands for others: the first run loads them."""


def _stand_in(name: str) -> ModuleType:
    provider = importlib.import_module(f"{__package__}.{_PROVIDERS[name]}")
    stand_ins: dict[str, ModuleType] = {module.__name__: module for module in provider.MODULES}
    return stand_ins[name]


class Replacements:
    """What stands for what, for the modules of the library that are loaded: nobody can have names of the others."""

    def __init__(self) -> None:
        self._replaced: set[str] = set()
        self._by_identity: dict[int, tuple[object, object]] = {}
        """Identity of an original -> the original and what stands for it.

        The original is kept alive. Otherwise it may be freed, as is the hook that pytest sets in `threading` for a
        session, and a later object, which gets the same identity, would be replaced as well.
        """
        self._renewed: dict[type, Callable[[Any], object]] = {}

    def update(self) -> None:
        """Know those that were loaded since."""
        for name in [module for module in _PROVIDERS if module in sys.modules and module not in self._replaced]:
            self._replaced.add(name)
            real, other = sys.modules[name], _stand_in(name)
            self._by_identity[id(real)] = real, other
            for key, value in vars(other).items():
                original = vars(real).get(key, value)
                if original is not value and not key.startswith("_"):
                    self._by_identity[id(original)] = original, value
            self._renewed |= vars(sys.modules[f"{__package__}.{_PROVIDERS[name]}"]).get("RENEWED", {})

    def of(self, value: object) -> object:
        """What stands for a value; the value itself if nothing does.

        A lock or queue that a module has is a new one in each run: what is left in it by one run is not in the next.
        """
        _, other = self._by_identity.get(id(value), (value, value))
        if other is value and type(value) in self._renewed:
            return self._renewed[type(value)](value)
        return other


_REPLACEMENTS = Replacements()
"""One for the process, as the modules of the library are."""


class VirtualModules:
    """Lets the modules under test see the stand-ins.

    Args:
        packages: of the code under test, by name.
    """

    def __init__(self, packages: Sequence[str]) -> None:
        self._packages = tuple(packages)
        self._roots = {package.partition(".")[0] for package in packages}
        self._undo: list[Callable[[], object]] = []
        self.imported: list[Callable[[], None]] = []
        """Called when the code under test has imported modules, before it goes on."""

    @property
    def packages(self) -> tuple[str, ...]:
        """Those of the code under test."""
        return self._packages

    @contextmanager
    def install(self) -> Iterator[None]:
        """The modules under test see them; also those that are imported in the meantime."""
        real_import = builtins.__import__
        self._replace()
        builtins.__import__ = self._make_import(real_import, len(sys.modules))
        try:
            yield
        finally:
            builtins.__import__ = real_import
            for undo in reversed(self._undo):
                undo()
            self._undo.clear()

    def _make_import(self, real_import: Callable[..., Any], loaded: int) -> Callable[..., Any]:
        def import_module(
            name: str, globals: Any = None, locals: Any = None, fromlist: Sequence[str] | None = (), level: int = 0
        ) -> Any:
            nonlocal loaded
            module = real_import(name, globals, locals, fromlist or (), level)
            by_code = self._is_of_code((globals or {}).get("__name__"))
            if (by_code or self._is_of_code(name)) and len(sys.modules) != loaded:
                self._replace()  # a module of the code under test may be new
                loaded = len(sys.modules)
                for notify in self.imported:
                    notify()
            if by_code and level == 0 and name in _PROVIDERS:
                return _import_result(name, module, bool(fromlist))
            if by_code and level == 0 and is_keyboard(module):
                return refuse_in_nodes(module)
            return module

        return import_module

    def _is_of_code(self, module: object) -> bool:
        return isinstance(module, str) and any(
            module == package or module.startswith(f"{package}.") for package in self._packages
        )

    def _replace(self) -> None:
        _REPLACEMENTS.update()
        roots = self._roots
        for name, module in [entry for entry in sys.modules.items() if entry[0].partition(".")[0] in roots]:
            if self._is_of_code(name) and isinstance(module, ModuleType):
                self._replace_in(name, vars(module))

    def _replace_in(self, module: str, names: dict[str, Any]) -> None:
        for name, value in list(names.items()):
            if isinstance(value, type) and value.__module__ == module:
                self._replace_in_class(value)
            other = refuse_in_nodes(value) if is_keyboard(value) else _REPLACEMENTS.of(value)
            if other is not value:
                names[name] = other
                self._undo.append(partial(names.__setitem__, name, value))

    def _replace_in_class(self, kind: type) -> None:
        """Its bases (`class Worker(Thread)`), its attributes, and what its methods enclose (`default_factory=Lock`)."""
        bases = tuple(_REPLACEMENTS.of(base) for base in kind.__bases__)
        if bases != kind.__bases__:
            self._undo.append(partial(setattr, kind, "__bases__", kind.__bases__))
            kind.__bases__ = bases  # type: ignore[assignment]
        for name, value in list(vars(kind).items()):
            other = _REPLACEMENTS.of(value)
            if other is not value:
                self._undo.append(partial(setattr, kind, name, value))
                setattr(kind, name, other)
            for cell in (value.__closure__ or ()) if isinstance(value, FunctionType) else ():
                self._replace_in_cell(cell)

    def _replace_in_cell(self, cell: Any) -> None:
        try:
            value = cell.cell_contents
        except ValueError:
            return  # empty
        other = _REPLACEMENTS.of(value)
        if other is not value:
            self._undo.append(partial(setattr, cell, "cell_contents", value))
            cell.cell_contents = other


def _import_result(name: str, module: ModuleType, has_names: bool) -> ModuleType:
    """What an import statement gets: of `import a.b` without names it is `a`, in which `b` is the stand-in."""
    other = _stand_in(name)
    if has_names or "." not in name:
        return other
    parent = ModuleType(module.__name__, module.__doc__)
    vars(parent).update({**vars(module), name.rpartition(".")[2]: other})
    return parent
