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
from types import ModuleType
from typing import Any, NoReturn

from pytest_hricdv.runtime.kernel import Kernel, KernelError

TIME = "time"
"""What a testbench names to have `time` and `datetime` in virtual time."""

EPOCH = real_datetime.datetime(2000, 1, 1, tzinfo=real_datetime.UTC)
"""The date of the beginning of each run: the same in each of them."""

_CLOCKS = ("time", "monotonic", "perf_counter", "process_time", "thread_time")
NS = 1_000_000_000


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
        self._is_virtual = is_virtual
        functions: dict[Callable[..., Any], Callable[..., Any]] = {real_time.sleep: self._wrapped("sleep", self._sleep)}
        for name in _CLOCKS:
            offset_s = EPOCH.timestamp() if name == "time" else 0.0
            functions[getattr(real_time, name)] = self._wrapped(name, self._clock(offset_s))
            functions[getattr(real_time, f"{name}_ns")] = self._wrapped(f"{name}_ns", self._clock_ns(offset_s))
        moment, day = self._datetime_classes()
        proxies = {function.__name__: proxy for function, proxy in functions.items()}
        pairs: list[tuple[object, object]] = [
            *functions.items(),
            (real_time, _module(real_time, proxies)),
            (real_datetime, _module(real_datetime, {"datetime": moment, "date": day})),
            (real_datetime.datetime, moment),
            (real_datetime.date, day),
        ]
        self._virtual: Mapping[int, object] = {id(real): proxy for real, proxy in pairs}
        self._real: Mapping[int, object] = {id(proxy): real for real, proxy in pairs}
        self._modules = {module.__name__: self._virtual[id(module)] for module in (real_time, real_datetime)}

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
        real_import, loaded = builtins.__import__, 0

        def importing(
            name: str, globals: Any = None, locals: Any = None, fromlist: Sequence[str] | None = (), level: int = 0
        ) -> Any:
            nonlocal loaded
            found = real_import(name, globals, locals, fromlist or (), level)
            by_code = self._is_of_code((globals or {}).get("__name__"))
            if by_code and level == 0 and name in self._modules:
                return self._modules[name]
            if (by_code or self._is_of_code(name)) and len(sys.modules) != loaded:
                self._replace(self._virtual)  # a module of the code under test may be new
                loaded = len(sys.modules)
            return found

        self._replace(self._virtual)
        builtins.__import__ = importing
        try:
            yield
        finally:
            builtins.__import__ = real_import
            self._replace(self._real)

    def _replace(self, others: Mapping[int, object]) -> None:
        """Give the names of the modules under test other values: identity of a value -> the other one."""
        for module_name, module in list(sys.modules.items()):
            if self._is_of_code(module_name) and isinstance(module, ModuleType):
                names = vars(module)
                for name, value in list(names.items()):
                    if id(value) in others:
                        names[name] = others[id(value)]


def _module(real: ModuleType, names: dict[str, Any]) -> ModuleType:
    """A module like a real one, but for these names."""
    made = ModuleType(real.__name__, real.__doc__)
    vars(made).update({**vars(real), **names})
    return made
