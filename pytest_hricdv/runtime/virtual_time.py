"""Python's own clocks as the code under test sees them: in virtual time, or refused with the line that asked them.

Code that is brought as it is sleeps with `time.sleep` and reads `time.monotonic` or `datetime.now`. In a simulated run
the one would wait in real time, in silence, and the others would make each run another one. So while a run goes on, the
names of `time` and `datetime` in the modules under test stand for those here. Nobody else sees them, and calls from
outside of a node go to the real ones: a module may ask for the time when it is imported.
"""

from __future__ import annotations

import builtins
import datetime as real_datetime
import sys
import time as real_time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property
from types import ModuleType
from typing import Any, NoReturn

from pytest_hricdv.runtime.kernel import Kernel, KernelError

TIME = "time"
"""What a testbench names to have `time` and `datetime` in virtual time."""

EPOCH = real_datetime.datetime(2000, 1, 1, tzinfo=real_datetime.UTC)
"""The date of the beginning of each run: the same in each of them."""

_CLOCKS = ("time", "monotonic", "perf_counter", "process_time", "thread_time")
NS = 1_000_000_000

_MODULES = {module.__name__: module for module in (real_time, real_datetime)}
_FUNCTIONS = (real_time.sleep, *(getattr(real_time, f"{name}{end}") for name in _CLOCKS for end in ("", "_ns")))
_REAL = {id(each) for each in (*_MODULES.values(), *_FUNCTIONS, real_datetime.datetime, real_datetime.date)}
"""Identities of what is replaced."""


class RealTimeError(KernelError):
    """The code under test asked for real time; the message says where, and how to let it have virtual time."""


class _LikeDatetime(type):
    """Of a class whose instances are all moments, also those that it did not make: `isinstance` is as without it."""

    def __instancecheck__(cls, instance: object) -> bool:
        return isinstance(instance, real_datetime.datetime)


class _LikeDate(type):
    """The same of days."""

    def __instancecheck__(cls, instance: object) -> bool:
        return isinstance(instance, real_datetime.date)


class VirtualTime:
    """Stands for `time` and `datetime` in the modules under test.

    Args:
        kernel: of the run.
        packages: of the code under test, by name.
        is_virtual: the testbench asks for virtual time; otherwise each use is an error.
    """

    def __init__(self, kernel: Kernel, packages: Sequence[str], *, is_virtual: bool) -> None:
        self._kernel = kernel
        self._packages = tuple(packages)
        self._roots = {package.partition(".")[0] for package in packages}
        self._is_virtual = is_virtual

    @cached_property
    def _pairs(self) -> list[tuple[object, object]]:
        """What is real, and what stands for it. Made only where the code under test knows anything of it."""
        functions: dict[Callable[..., Any], Callable[..., Any]] = {real_time.sleep: self._wrapped("sleep", self._sleep)}
        for name in _CLOCKS:
            offset_s = EPOCH.timestamp() if name == "time" else 0.0
            functions[getattr(real_time, name)] = self._wrapped(name, self._clock(offset_s))
            functions[getattr(real_time, f"{name}_ns")] = self._wrapped(f"{name}_ns", self._clock_ns(offset_s))
        moment, day = self._datetime_classes()
        proxies = {function.__name__: proxy for function, proxy in functions.items()}
        return [
            *functions.items(),
            (real_time, _module(real_time, proxies)),
            (real_datetime, _module(real_datetime, {"datetime": moment, "date": day})),
            (real_datetime.datetime, moment),
            (real_datetime.date, day),
        ]

    @cached_property
    def _virtual(self) -> Mapping[int, object]:
        """Identity of what is real -> what stands for it."""
        return {id(real): proxy for real, proxy in self._pairs}

    def _wrapped(self, name: str, virtual: Callable[..., Any]) -> Callable[..., Any]:
        """A function of `time` as the code under test has it."""
        real = getattr(real_time, name)

        def function(*arguments: Any) -> Any:
            if self._kernel.running() is None:
                return real(*arguments)
            return virtual(*arguments) if self._is_virtual else self._refuse(f"time.{name}")

        function.__name__ = name
        return function

    def _sleep(self, duration_s: float) -> None:
        self._kernel.sleep(duration_s)

    def _clock(self, offset_s: float) -> Callable[[], float]:
        def read() -> float:
            self._kernel.count_poll()
            return offset_s + self._kernel.now_s

        return read

    def _clock_ns(self, offset_s: float) -> Callable[[], int]:
        def read() -> int:
            self._kernel.count_poll()
            return round(offset_s * NS) + self._kernel.now_us * 1000

        return read

    def _datetime_classes(self) -> tuple[type[real_datetime.datetime], type[real_datetime.date]]:
        now = self._now

        class VirtualDatetime(real_datetime.datetime, metaclass=_LikeDatetime):
            """A moment whose present is that of the run."""

            @classmethod
            def now(cls, tz: real_datetime.tzinfo | None = None) -> Any:
                return now("datetime.now", tz)

            @classmethod
            def utcnow(cls) -> Any:
                return now("datetime.utcnow", None)

            @classmethod
            def today(cls) -> Any:
                return now("datetime.today", None)

        class VirtualDate(real_datetime.date, metaclass=_LikeDate):
            """A day whose present is that of the run."""

            @classmethod
            def today(cls) -> Any:
                return now("date.today", None).date()

        return VirtualDatetime, VirtualDate

    def _now(self, name: str, tz: real_datetime.tzinfo | None) -> real_datetime.datetime:
        if self._kernel.running() is None:
            return real_datetime.datetime.now(tz)
        if not self._is_virtual:
            self._refuse(name)
        self._kernel.count_poll()
        moment = EPOCH + real_datetime.timedelta(microseconds=self._kernel.now_us)
        return moment.astimezone(tz) if tz is not None else moment.replace(tzinfo=None)

    def _refuse(self, name: str) -> NoReturn:
        frame = sys._getframe(2)
        while frame.f_back is not None and not self._is_of_code(frame.f_globals.get("__name__")):
            frame = frame.f_back
        where = f"{frame.f_code.co_filename}:{frame.f_lineno}"
        node = self._kernel.current().name
        raise RealTimeError(
            f"{where}: {name} in node {node} is real time, of which a simulated run has none: give the testbench "
            f'virtual=("{TIME}",) to have time and datetime in virtual time, or let the code use the clock of its port'
        )

    def _is_of_code(self, module: object) -> bool:
        return isinstance(module, str) and any(
            module == package or module.startswith(f"{package}.") for package in self._packages
        )

    @contextmanager
    def installed(self) -> Iterator[None]:
        """The modules under test see it; also those that are imported in the meantime."""
        real_import, loaded = builtins.__import__, len(sys.modules)

        def importing(
            name: str, globals: Any = None, locals: Any = None, fromlist: Sequence[str] | None = (), level: int = 0
        ) -> Any:
            nonlocal loaded
            found = real_import(name, globals, locals, fromlist or (), level)
            by_code = self._is_of_code((globals or {}).get("__name__"))
            if by_code and level == 0 and name in _MODULES:
                return self._virtual[id(_MODULES[name])]
            if (by_code or self._is_of_code(name)) and len(sys.modules) != loaded:
                self._let_see_virtual()  # a module of the code under test may be new
                loaded = len(sys.modules)
            return found

        self._let_see_virtual()
        builtins.__import__ = importing
        try:
            yield
        finally:
            builtins.__import__ = real_import
            self._let_see_real()

    def _let_see_virtual(self) -> None:
        for names in self._namespaces():
            for name in [name for name, value in names.items() if id(value) in _REAL]:
                names[name] = self._virtual[id(names[name])]

    def _let_see_real(self) -> None:
        if "_pairs" not in vars(self):
            return
        real = {id(proxy): original for original, proxy in self._pairs}
        for names in self._namespaces():
            for name in [name for name, value in names.items() if id(value) in real]:
                names[name] = real[id(names[name])]

    def _namespaces(self) -> list[dict[str, Any]]:
        """Of the modules under test."""
        roots = self._roots
        found = [(name, module) for name, module in sys.modules.items() if name.partition(".")[0] in roots]
        return [vars(module) for name, module in found if self._is_of_code(name) and isinstance(module, ModuleType)]


def _module(real: ModuleType, names: dict[str, Any]) -> ModuleType:
    """A module like a real one, but for these names."""
    made = ModuleType(real.__name__, real.__doc__)
    vars(made).update({**vars(real), **names})
    return made
