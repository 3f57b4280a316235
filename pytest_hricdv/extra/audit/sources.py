"""Sources of nondeterminism: random numbers, clocks, file times and the like, which a run may read.

`SourceWatch` replaces such functions of Python in a fresh process. It either reports the lines that call them, or
freezes them, so they return the same in each run. A run that repeats only then depends on the frozen kind of source.
`audit.process` uses it in reruns; `CauseSearch` says which kinds to freeze.

Only calls from the project's own files count: the plugin, pytest and libraries make most of them all the time.
"""

from __future__ import annotations

import builtins
import datetime
import importlib
import io
import itertools
import os
import random
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType, ModuleType, TracebackType
from typing import Any

import msgspec

from pytest_hricdv.runtime.kernel import current_node

PACKAGE = str(Path(__file__).parents[2])
_INSTALLED = tuple({os.path.dirname(os.__file__), os.path.dirname(importlib.__file__)})

RANDOM, CLOCK, FILE_TIMES, PROCESS, LISTING = (
    "random numbers",
    "wall clock",
    "times of files",
    "number of the process",
    "order of a folder",
)
THREADS, OTHERS, FILES = "threads", "other processes", "files"
"""Kinds that cannot be frozen: reads of them are only reported."""

KINDS = (RANDOM, CLOCK, FILE_TIMES, PROCESS, LISTING)
"""Kinds that can be frozen, in the order in which they are tried."""

_MOST_READINGS = 20
"""Maximum number of locations to keep of each kind of source: more than anybody reads."""


class Reading(msgspec.Struct, frozen=True):
    """A read of a source of nondeterminism: its kind, the function, and the call's location; for a file, its path."""

    kind: str
    what: str
    place: str
    path: str = ""


def _stream() -> Callable[[int], bytes]:
    generator = random.Random(1)
    return lambda size: generator.randbytes(size)


def _ticks(unit: float) -> Callable[..., float]:
    """A clock that advances by a millisecond at each call, so that a loop that waits for a time ends."""
    count = itertools.count(1)
    return lambda *arguments: next(count) * unit


def _ticks_ns() -> Callable[..., int]:
    count = itertools.count(1)
    return lambda *arguments: next(count) * 1_000_000


def _still_stat(real: Callable[..., os.stat_result]) -> Callable[..., os.stat_result]:
    def stat(*arguments: Any, **options: Any) -> os.stat_result:
        status = real(*arguments, **options)
        times = {f"st_{kind}time{unit}": 0 for kind in "amc" for unit in ("", "_ns")}
        return os.stat_result((*status[:7], 0, 0, 0), times)

    return stat


class _StillDatetime(datetime.datetime):
    """A frozen `datetime`; nodes have that of their run."""

    @classmethod
    def now(cls, tz: datetime.tzinfo | None = None) -> _StillDatetime:
        return cls(2000, 1, 1, tzinfo=tz) if current_node() is None else super().now(tz)

    @classmethod
    def utcnow(cls) -> _StillDatetime:
        return cls(2000, 1, 1) if current_node() is None else super().utcnow()

    @classmethod
    def today(cls) -> _StillDatetime:
        return cls(2000, 1, 1) if current_node() is None else super().today()


def _sort(real: Callable[..., Any]) -> Callable[..., Any]:
    return lambda *arguments: sorted(real(*arguments))


_FUNCTIONS: tuple[tuple[str, str, str, Callable[[Any], Any] | None], ...] = (
    *(
        (RANDOM, "random", name, None)
        for name in ("random", "randint", "randrange", "uniform", "gauss", "choice", "choices", "sample", "shuffle")
    ),
    (RANDOM, "os", "urandom", lambda real: _stream()),
    (RANDOM, "random", "_urandom", lambda real: _stream()),
    (RANDOM, "uuid", "uuid1", None),
    (RANDOM, "uuid", "uuid4", None),
    (RANDOM, "secrets", "token_bytes", None),
    (RANDOM, "secrets", "token_hex", None),
    (RANDOM, "secrets", "randbelow", None),
    *((CLOCK, "time", name, lambda real: _ticks(0.001)) for name in ("time", "monotonic", "perf_counter")),
    (CLOCK, "time", "process_time", lambda real: _ticks(0.001)),
    *((CLOCK, "time", f"{name}_ns", lambda real: _ticks_ns()) for name in ("time", "monotonic", "perf_counter")),
    *((FILE_TIMES, "os", name, _still_stat) for name in ("stat", "lstat", "fstat")),
    (PROCESS, "os", "getpid", lambda real: lambda: 1),
    (PROCESS, "os", "getppid", lambda real: lambda: 1),
    (LISTING, "os", "listdir", _sort),
)
"""Kind, module, name, and how to freeze it; None for what is only reported."""

_EVENTS = {
    "open": FILES,
    "subprocess.Popen": OTHERS,
    "socket.connect": OTHERS,
    "_thread.start_new_thread": THREADS,
}
"""Events of `sys.audit` -> their kinds: reported, and never frozen."""


class SourceWatch:
    """Context manager within which sources are reported or frozen, and files are hidden.

    Args:
        root: folder of the project.
        still: kinds that stand still.
        watched: whether to notice what is read.
        hidden: paths of files that are not there.
    """

    def __init__(self, root: str, *, still: tuple[str, ...], watched: bool, hidden: tuple[str, ...]) -> None:
        # Compared as texts: asking the system for a path would call what is replaced here.
        self._roots = tuple({os.path.abspath(root) + os.sep, os.path.realpath(root) + os.sep})
        self._still = still
        self._watched = watched
        self._hidden = {form(path) for path in hidden for form in (os.path.abspath, os.path.realpath)}
        self._readings: dict[Reading, None] = {}
        self._undo: list[Callable[[], None]] = []
        self._is_over = False

    def readings(self) -> tuple[Reading, ...]:
        """The readings in order, without duplicates."""
        kept: dict[str, list[Reading]] = {}
        for reading in self._readings:
            kept.setdefault(reading.kind, []).append(reading)
        return tuple(reading for readings in kept.values() for reading in readings[:_MOST_READINGS])

    def __enter__(self) -> SourceWatch:
        if self._watched:
            sys.addaudithook(self._hear)  # it stays, and this process ends with the run
        for kind, module, name, standing in _FUNCTIONS:
            if module in sys.modules and (self._watched or kind in self._still):
                still = standing if kind in self._still else None
                self._replace(kind, sys.modules[module], name, still)
        if self._watched or RANDOM in self._still:
            self._seed(still=RANDOM in self._still)
        if CLOCK in self._still:
            self._put(sys.modules["datetime"], "datetime", _StillDatetime)
        if self._hidden:
            self._hide()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._is_over = True
        for undo in reversed(self._undo):
            undo()

    def _replace(self, kind: str, module: ModuleType, name: str, standing: Callable[[Any], Any] | None) -> None:
        real = getattr(module, name, None)
        if real is None or isinstance(real, type):  # a class stays one
            return
        inner = standing(real) if standing is not None else real
        label = f"{module.__name__}.{name}".lstrip("_")

        def notice(*arguments: Any, **options: Any) -> Any:
            is_virtual = kind == CLOCK and current_node() is not None
            place = "" if is_virtual else self._place(sys._getframe(1))
            if place:
                self._readings.setdefault(Reading(kind, label, place, _path(arguments) if kind == FILE_TIMES else ""))
                return inner(*arguments, **options)
            return real(*arguments, **options)

        self._put(module, name, notice)

    def _put(self, module: ModuleType, name: str, value: Any) -> None:
        """Replace an attribute of a module, and each reference to it in modules of the project."""
        real = getattr(module, name)
        for holder in (module, *self._own_modules()):
            for key in [key for key, held in vars(holder).items() if held is real]:
                setattr(holder, key, value)
                self._undo.append(lambda holder=holder, key=key: setattr(holder, key, real))  # type: ignore[misc]

    def _own_modules(self) -> Iterator[ModuleType]:
        for module in [*sys.modules.values()]:
            file = getattr(module, "__file__", None)
            if isinstance(module, ModuleType) and isinstance(file, str) and self._is_own(file):
                yield module

    def _seed(self, *, still: bool) -> None:
        """Report generators created without a seed, or give them one."""
        sources, real = self, random.Random.seed

        def seed(generator: random.Random, a: Any = None, version: int = 2) -> None:
            place = sources._place(sys._getframe(1)) if a is None else ""
            if place:
                sources._readings.setdefault(Reading(RANDOM, "random.Random without a seed", place))
            real(generator, 0 if a is None and still else a, version)

        random.Random.seed = seed  # type: ignore[assignment, method-assign]
        self._undo.append(lambda: setattr(random.Random, "seed", real))
        numpy = sys.modules.get("numpy")
        if numpy is not None:
            make = numpy.random.default_rng

            def default_rng(seed: Any = None) -> Any:
                place = sources._place(sys._getframe(1)) if seed is None else ""
                if place:
                    sources._readings.setdefault(Reading(RANDOM, "numpy.random.default_rng without a seed", place))
                return make(0 if seed is None and still else seed)

            self._put(numpy.random, "default_rng", default_rng)
        if still:
            random.seed(0)
            if numpy is not None:
                numpy.random.seed(0)

    def _hide(self) -> None:
        """Let hidden files appear not to exist."""

        def hide(real: Callable[..., Any]) -> Callable[..., Any]:
            def absent(path: Any, *arguments: Any, **options: Any) -> Any:
                modes = (*arguments[:1], options.get("mode"))
                if self._is_hidden(path) and not any(isinstance(mode, str) and mode[:1] in "wax" for mode in modes):
                    raise FileNotFoundError(2, "No such file or directory", os.fsdecode(path))
                return real(path, *arguments, **options)

            return absent

        def ask(real: Callable[[Any], bool]) -> Callable[[Any], bool]:
            return lambda path: not self._is_hidden(path) and real(path)

        for module, name in ((builtins, "open"), (io, "open"), (os, "stat"), (os, "lstat")):
            self._put(module, name, hide(getattr(module, name)))
        for name in ("exists", "isfile", "lexists"):  # on Windows they are in C, and do not ask os.stat
            self._put(os.path, name, ask(getattr(os.path, name)))

    def _is_hidden(self, path: Any) -> bool:
        return isinstance(path, str | bytes | os.PathLike) and os.path.abspath(os.fsdecode(path)) in self._hidden

    def _hear(self, event: str, arguments: tuple[Any, ...]) -> None:
        kind = _EVENTS.get(event)
        if kind is None or self._is_over:
            return
        path = ""
        if kind == FILES:
            if not isinstance(arguments[0], str | bytes):
                return
            path = os.path.abspath(os.fsdecode(arguments[0]))
            if path.endswith((".py", ".pyc")):
                return
        place = self._place(sys._getframe(1))
        if place:
            self._readings.setdefault(Reading(kind, event, place, path))

    def _place(self, frame: FrameType | None) -> str:
        """The line of the project that makes a call, perhaps through libraries; empty for calls of the plugin or of
        pytest."""
        while frame is not None:
            file = frame.f_code.co_filename
            if self._is_own(file) and frame.f_lineno:  # without a line, it is being imported
                root = next(root for root in self._roots if file.startswith(root))
                return f"{file.removeprefix(root)}:{frame.f_lineno}"
            if file.startswith(PACKAGE) or not _is_library(file):
                return ""
            frame = frame.f_back
        return ""

    def _is_own(self, file: str) -> bool:
        return file.startswith(self._roots) and not file.startswith(PACKAGE) and "site-packages" not in file


def _path(arguments: tuple[Any, ...]) -> str:
    """The path that a function was called with; empty if its argument is none."""
    path = arguments[0] if arguments else None
    return os.path.abspath(os.fsdecode(path)) if isinstance(path, str | bytes | os.PathLike) else ""


def _is_library(file: str) -> bool:
    return "site-packages" in file or file.startswith((*_INSTALLED, "<frozen"))
