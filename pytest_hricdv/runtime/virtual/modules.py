"""`VirtualModules`: replaces Python's library during a run, in the modules that the code under test reaches.

Code that is brought as it is sleeps with `time.sleep`, reads `datetime.now`, waits for events and queues of other
threads, or runs an event loop. In a simulated run these would wait in real time, in silence, or make each run another
one. The stand-ins wait in virtual time, or refuse where the testbench did not ask for it. Outside of nodes they are the
real ones as far as that makes sense: a module may ask for the time when it is imported.
"""

from __future__ import annotations

import builtins
import importlib
import logging
import sys
import threading
import weakref
from collections.abc import Callable, Iterator, Sequence, Set
from contextlib import contextmanager
from functools import partial, wraps
from types import ModuleType
from typing import Any

from pytest_hricdv.runtime.redirection import redirect
from pytest_hricdv.runtime.virtual.clocks import is_moment_call
from pytest_hricdv.runtime.virtual.holders import Reference, with_others
from pytest_hricdv.runtime.virtual.prohibition import is_keyboard, refuse_in_nodes
from pytest_hricdv.runtime.virtual.reach import Reach, is_initializing, is_module
from pytest_hricdv.runtime.virtual.real_time import ProhibitedError
from pytest_hricdv.runtime.virtual.references import ReferenceSearch

_PROVIDERS = {
    "threading": "threads",
    "_thread": "threads",
    "queue": "threads",
    "concurrent.futures": "thread_pool",
    "asyncio": "asyncio_functions",
    "uuid": "clocks",
    "sched": "threads",
}
"""Module of the library -> the module here that has its stand-in."""

STAND_INS = tuple(f"{__package__}.{name}" for name in sorted({*_PROVIDERS.values()}))
"""The modules here with stand-ins: the first run loads them."""


def _stand_in(name: str) -> ModuleType:
    provider = importlib.import_module(f"{__package__}.{_PROVIDERS[name]}")
    stand_ins: dict[str, ModuleType] = {module.__name__: module for module in provider.MODULES}
    return stand_ins[name]


class Replacements:
    """The replacements for loaded modules of the library: nobody can have names of the others."""

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
            self._by_identity.setdefault(id(real), (real, other))
            if "." in name:  # of `import a.b`, modules have `a`
                parent = sys.modules[name.rpartition(".")[0]]
                self._by_identity.setdefault(id(parent), (parent, _import_result(name, parent, has_names=False)))
            for key, value in vars(other).items():
                original = getattr(real, key, value)  # also what a module loads when somebody asks for it
                is_clock = getattr(original, "__module__", "") == "time"  # as `queue` has: redirected for everybody
                if original is not value and not key.startswith("_") and not is_clock:
                    self._by_identity.setdefault(id(original), (original, value))
            self._renewed |= vars(sys.modules[f"{__package__}.{_PROVIDERS[name]}"]).get("RENEWED", {})

    def __contains__(self, value: object) -> bool:
        is_known = id(value) in self._by_identity or self.is_renewed(value) or is_moment_call(value)
        return is_known or issubclass(_kind(value), threading.local)

    def is_renewed(self, value: object) -> bool:
        """Whether it is a lock or a queue."""
        return type(value) in self._renewed

    def of(self, value: object) -> object:
        """The replacement for a value; the value itself if there is none.

        A module's lock or queue is a new one in each run, without leftovers of the last one.
        """
        if is_moment_call(value):
            redirect(value, getattr(value.__self__, value.__name__))  # type: ignore[attr-defined]
        _, other = self._by_identity.get(id(value), (value, value))
        if other is value and issubclass(_kind(value), threading.local):
            threads = importlib.import_module(f"{__package__}.threads")
            return threads.local_like(value) if value is _kind(value) else threads.local_again(value)
        if other is value and type(value) in self._renewed:
            return self._renewed[type(value)](value)
        return other


def _kind(value: object) -> type:
    return value if issubclass(type(value), type) else type(value)  # type: ignore[return-value]


_REPLACEMENTS = Replacements()
"""One for the process, like the modules of the library."""


class VirtualModules:
    """Lets the modules that the code under test reaches see the stand-ins.

    Args:
        packages: the packages of the code under test, by name.
    """

    def __init__(self, packages: Sequence[str]) -> None:
        self._reach = Reach(packages)
        self._undo: list[Callable[[], object]] = []
        self._done: set[str] = set()
        self._made: dict[int, tuple[object, object]] = {}
        """Identity of an object that is renewed for each run, as a lock -> the object and what stands for it."""
        self.imported: list[Callable[[], None]] = []
        """Called when the code under test has imported modules, before it continues."""

    @property
    def packages(self) -> tuple[str, ...]:
        """The packages of the code under test."""
        return self._reach.packages

    @contextmanager
    def install(self) -> Iterator[None]:
        """The modules see them; also those that are imported in the meantime."""
        real_import, real_import_module = builtins.__import__, importlib.import_module
        loaded = {*sys.modules}
        self._refuse_threads()
        self._replace()
        self._undo.append(_begin_logs())
        builtins.__import__ = self._make_import(real_import)
        importlib.import_module = self._make_import_module(real_import_module)
        try:
            yield
        finally:
            importlib.import_module = real_import_module
            builtins.__import__ = real_import
            for undo in reversed(self._undo):
                undo()
            self._undo.clear()
            self._restore_in(sys.modules.keys() - loaded)
            self._done.clear()
            self._made.clear()

    def _refuse_threads(self) -> None:
        """Refuse threads that the code under test has begun before: they go on in real time, and meet nobody."""
        for thread in threading.enumerate():
            function = getattr(thread, "_target", None) or type(thread).run
            module = getattr(function, "__module__", None)
            if not isinstance(module, str) or not self._reach.is_code(module):
                continue
            thread.join(0.5)  # it may have been told to end
            if thread.is_alive():
                raise ProhibitedError(
                    f"thread {thread.name} of {module}.{function.__qualname__} was started before the run, as its "
                    "module was imported or by another test, and continues in real time: start it in a function of the "
                    "code that is called in the run, or end it"
                )

    def _restore_in(self, names: Set[str]) -> None:
        """Give modules that were imported in the run the originals of what others gave them, as a lock."""
        originals = {id(made): value for value, made in self._made.values() if made is not value}

        def original(value: object) -> object:
            return originals[id(value)] if id(value) in originals else with_others(value, original)

        for name in sorted(names):
            module = sys.modules.get(name)
            if name in self._reach and module is not None and is_module(module):
                search = ReferenceSearch(lambda value: id(value) in originals, self._reach)
                for value, put in [*search.find(vars(module))]:
                    put(original(value))
                _IN_LIBRARIES.pop(module, None)

    def _make_import(self, real_import: Callable[..., Any]) -> Callable[..., Any]:
        loaded = len(sys.modules)

        def import_module(
            name: str, globals: Any = None, locals: Any = None, fromlist: Sequence[str] | None = (), level: int = 0
        ) -> Any:
            nonlocal loaded
            module = real_import(name, globals, locals, fromlist or (), level)
            is_reached = (globals or {}).get("__name__") in self._reach
            is_new = len(sys.modules) != loaded and (is_reached or name in self._reach)
            if is_new or (is_reached and self._reach.lacks(name)):  # an earlier run may have loaded it
                self._replace(sys.modules.keys() & {name, *(f"{name}.{member}" for member in fromlist or ())})
                loaded = len(sys.modules)
                for notify in self.imported:
                    notify()
            if is_reached and level == 0 and name in _PROVIDERS:
                return _import_result(name, module, bool(fromlist))
            if is_reached and level == 0 and is_keyboard(module):
                return refuse_in_nodes(module)
            return module

        return import_module

    def _make_import_module(self, real: Callable[..., ModuleType]) -> Callable[..., ModuleType]:
        @wraps(real)
        def import_module(name: str, package: str | None = None) -> ModuleType:
            loaded, module = len(sys.modules), real(name, package)
            if sys._getframe(1).f_globals.get("__name__") in self._reach:
                if len(sys.modules) != loaded or self._reach.lacks(module.__name__):
                    self._replace({module.__name__})
                if name in _PROVIDERS:
                    return _stand_in(name)
            return module

        return import_module

    def _replace(self, imported: Set[str] = frozenset()) -> None:
        """Replace what modules refer to, and was not replaced yet.

        Args:
            imported: modules that the code under test has imported since.
        """
        _REPLACEMENTS.update()
        self._reach.add(imported)
        for name, module in self._reach.modules().items():
            if name in self._done:
                continue
            for value, put in self._references(name, module):
                put(self._replacement(value))
                self._undo.append(partial(put, value))
            if module in _IN_LIBRARIES:
                self._done.add(name)

    def _replacement(self, value: object) -> object:
        """What stands for a value: one for all of its users, as modules that share a queue meet in it."""
        if id(value) not in self._made:
            made: Any = refuse_in_nodes(value) if is_keyboard(value) else _REPLACEMENTS.of(value)
            if made is value:
                made = with_others(value, self._replacement)
            if (
                type(value) is threading.Condition
            ):  # its lock may have a name of its own, or be that of another condition
                made = type(made)(self._replacement(vars(value)["_lock"]))
            elif made is not value and issubclass(type(value), threading.Thread):
                for name in ("function", "_target"):  # of a timer, or a thread
                    if name in vars(made):
                        setattr(made, name, self._replacement(vars(made)[name]))
            self._made[id(value)] = value, made
        return self._made[id(value)][1]

    def _references(self, name: str, module: ModuleType) -> Sequence[Reference]:
        """The references to replace in a module. Libraries are searched once; the state of the code under test
        changes."""
        references = None if self._reach.is_code(name) else _IN_LIBRARIES.get(module)
        if references is None:
            search = ReferenceSearch(lambda value: is_keyboard(value) or value in _REPLACEMENTS, self._reach)
            references = tuple(search.find(vars(module)))
            if not is_initializing(module):
                _IN_LIBRARIES[module] = references
        return references


_IN_LIBRARIES: weakref.WeakKeyDictionary[ModuleType, tuple[Reference, ...]] = weakref.WeakKeyDictionary()


def _begin_logs() -> Callable[[], object]:
    """Let `relativeCreated` of records of `logging` count from the beginning of the run; returns what undoes it."""
    names: dict[str, Any] = vars(logging)
    start = names["_startTime"]
    epoch_s = importlib.import_module(f"{__package__}.clocks").EPOCH.timestamp()
    names["_startTime"] = round(epoch_s * 1e9) if isinstance(start, int) else epoch_s  # ns, from Python 3.13 on
    return partial(names.__setitem__, "_startTime", start)


def _import_result(name: str, module: ModuleType, has_names: bool) -> ModuleType:
    """The result of an import statement: for `import a.b` without names it is `a`, in which `b` is the replacement."""
    other = _stand_in(name)
    if has_names or "." not in name:
        return other
    parent = ModuleType(module.__name__, module.__doc__)
    vars(parent).update({**vars(module), name.rpartition(".")[2]: other})
    return parent
