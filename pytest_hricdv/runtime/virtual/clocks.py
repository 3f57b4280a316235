"""`time`, `datetime` and `uuid` in virtual time; outside of a run's nodes, each function is the real one.

UUIDs are the same in each repetition of a run, and no two of a run are equal.
"""

from __future__ import annotations

import datetime
import operator
import sys
import threading
import time
import uuid
from collections.abc import Callable, Collection
from hashlib import sha256
from itertools import count
from types import BuiltinFunctionType, FrameType
from typing import Any, cast

from pytest_hricdv.runtime.blocking_calls import TIME
from pytest_hricdv.runtime.kernel import current_node
from pytest_hricdv.runtime.redirection import original, replace_in_class
from pytest_hricdv.runtime.source_location import place_of
from pytest_hricdv.runtime.virtual.reach import is_tool
from pytest_hricdv.runtime.virtual.real_time import RealTimeError, check
from pytest_hricdv.runtime.virtual.references import stand_in

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

EPOCH = datetime.datetime(2000, 1, 1, tzinfo=datetime.UTC)
"""The date of the beginning of each run: the same in each of them (chosen)."""

real_time: Any = stand_in(time, {name: original(function) for name, function in vars(time).items()})
"""The module `time` with functions that are never redirected."""

_CLOCKS = ("time", "monotonic", "perf_counter", "process_time", "thread_time")
_NS_PER_S = 1_000_000_000


def monotonic() -> float:
    """The time of the run (s), whatever the testbench says: what waits in virtual time measures its time-outs so."""
    node = current_node()
    return real_time.monotonic() if node is None else node.kernel.now_s


def seconds(duration_s: Any) -> float:
    """A duration (s) that Python's own functions take: a float, or what is an integer.

    Raises:
        TypeError: it is neither, as a `Decimal`.
        OverflowError: it is longer than Python's own functions wait.
    """
    duration_s = duration_s if isinstance(duration_s, float) else operator.index(duration_s)
    if duration_s > threading.TIMEOUT_MAX:
        raise OverflowError("timestamp out of range for platform time_t")
    return cast(float, duration_s)


def sleep(duration_s: float) -> None:
    """Like `time.sleep`."""
    node = current_node()
    if node is None:
        real_time.sleep(duration_s)  # outside of a run, time is real
        return
    check(node, TIME, "time.sleep")
    duration_s = seconds(duration_s)
    if not duration_s >= 0:
        raise ValueError("sleep length must be non-negative")  # as Python does
    node.kernel.sleep(duration_s)


def _now_us(name: str, depth: int = 2) -> int | None:
    """The time of the run, for the caller at this depth of the stack; None outside of a node, and for tools."""
    node = current_node()
    if node is None or is_tool(caller := sys._getframe(depth)):
        return None
    if TIME not in node.kernel.virtual and is_of_code(caller, node.kernel.code):
        check(node, TIME, name)
    node.kernel.count_clock_read()
    return node.kernel.now_us


def is_of_code(frame: FrameType, code: Collection[str]) -> bool:
    """Whether the code under test asks. Libraries, as for a line in a log, ask on nobody's behalf."""
    module = str(frame.f_globals.get("__name__", ""))
    return any(module == package or module.startswith(f"{package}.") for package in code)


def _clock(name: str) -> Callable[[], float]:
    real = getattr(real_time, name)
    offset_s = EPOCH.timestamp() if name == "time" else 0.0

    def read() -> float:
        now_us = _now_us(f"time.{name}")
        return float(real()) if now_us is None else offset_s + now_us / 1e6

    return read


def _clock_ns(name: str) -> Callable[[], int]:
    real = getattr(real_time, f"{name}_ns")
    offset_ns = round(EPOCH.timestamp()) * _NS_PER_S if name == "time" else 0

    def read() -> int:
        now_us = _now_us(f"time.{name}_ns")
        return int(real()) if now_us is None else offset_ns + now_us * 1000

    return read


def _moment(kind: Any, now_us: int, tz: datetime.tzinfo | None) -> Any:
    """The same moment as an instance of `datetime`, or of a subclass."""
    moment = EPOCH + datetime.timedelta(microseconds=now_us)
    moment = moment.astimezone(tz) if tz is not None else moment.replace(tzinfo=None)
    return moment if kind is _DATETIME else kind.combine(moment.date(), moment.timetz())


def now(cls: type, tz: datetime.tzinfo | None = None) -> Any:
    """Like that of `datetime.datetime`."""
    now_us = _now_us("datetime.now")
    return _REAL["now"].__get__(None, cls)(tz) if now_us is None else _moment(cls, now_us, tz)


def utcnow(cls: type) -> Any:
    """Like that of `datetime.datetime`."""
    now_us = _now_us("datetime.utcnow")
    return _REAL["utcnow"].__get__(None, cls)() if now_us is None else _moment(cls, now_us, None)


def today(cls: Any) -> Any:
    """Like that of `datetime.datetime` and `datetime.date`."""
    now_us = _now_us("datetime.today")
    if now_us is None:
        return _REAL["today"].__get__(None, cls)()
    moment = _moment(cls if issubclass(cls, _DATETIME) else _DATETIME, now_us, None)
    return moment if issubclass(cls, _DATETIME) else cls(moment.year, moment.month, moment.day)


_DATETIME, _DATE = datetime.datetime, datetime.date
_REAL = {
    function.__name__: replace_in_class(kind, function.__name__, classmethod(function))
    for kind, function in ((_DATETIME, now), (_DATETIME, utcnow), (_DATE, today))
}
"""Class methods as they were: who has those of subclasses, too, calls the ones here, and outside of runs these."""


def is_moment_call(value: Any) -> bool:
    """Whether it is such a method, which somebody has kept since before it was replaced."""
    kind = value.__self__ if type(value) is BuiltinFunctionType else None
    return issubclass(type(kind), type) and issubclass(kind, _DATE) and value.__name__ in _REAL  # type: ignore[arg-type]


def uuid4() -> uuid.UUID:
    """Like that of `uuid`, but in a run it is made of how many there were before."""
    node = current_node()
    if node is None:
        return uuid.uuid4()
    numbers: Any = node.kernel.own.setdefault("identifiers", count())
    # Hashed, so that they look as random as real ones: code may use the first digits only. A UUID has 16 bytes.
    return uuid.UUID(bytes=sha256(b"%d" % next(numbers)).digest()[:16], version=4)


def uuid1(node: int | None = None, clock_seq: int | None = None) -> uuid.UUID:
    """Like that of `uuid`; in a run it names no machine and no time, but is one of `uuid4`."""
    return uuid.uuid1(node, clock_seq) if current_node() is None else uuid4()


def uuid6(node: int | None = None, clock_seq: int | None = None) -> uuid.UUID:
    """Like that of `uuid` from Python 3.14 on; see `uuid1`."""
    return _real("uuid6")(node, clock_seq) if current_node() is None else uuid4()


def uuid7() -> uuid.UUID:
    """Like that of `uuid` from Python 3.14 on; in a run it has the time of the run, and later ones are larger."""
    node = current_node()
    if node is None:
        return _real("uuid7")()
    numbers: Any = node.kernel.own.setdefault("timed identifiers", count())
    number = next(numbers)
    # RFC 9562: 48 bits of milliseconds, 4 of version, 12 and (after 2 of variant) 62 bits, here a count and its hash.
    hashed = int.from_bytes(sha256(b"timed %d" % number).digest()[:4], "big")
    high, low = divmod(number << 32 | hashed, 1 << 62)
    now_ms = round(EPOCH.timestamp()) * 1000 + node.kernel.now_us // 1000
    return uuid.UUID(int=now_ms << 80 | 7 << 76 | high << 64 | 2 << 62 | low)


def _real(name: str) -> Callable[..., uuid.UUID]:
    return cast(Callable[..., uuid.UUID], getattr(uuid, name))


def _clock_by_id(name: str, in_ns: bool) -> Callable[[int], Any]:
    real: Callable[[int], Any] = getattr(real_time, name)

    def read(clk_id: int, /) -> Any:
        now_us = _now_us(f"time.{name}")
        if now_us is None:
            return real(clk_id)
        if clk_id == real_time.CLOCK_REALTIME:
            now_us += round(EPOCH.timestamp()) * 1_000_000
        return now_us * 1000 if in_ns else now_us / 1e6

    return read


def _moment_call(name: str, position: int) -> Callable[..., Any]:
    """A function of `time` whose argument at this position is a moment, and may be left out: then it is now."""
    # The zone of runs is UTC, as of `datetime.now`: that of the machine would make each a run of its own.
    utc = {"localtime": "gmtime", "ctime": "asctime"}.get(name, name)
    real: Callable[..., Any] = getattr(real_time, name)
    of_run: Callable[..., Any] = getattr(real_time, utc)

    def read(*args: Any) -> Any:
        if args[position:] in ((), (None,)) and (now_us := _now_us(f"time.{name}")) is not None:
            now_s = EPOCH.timestamp() + now_us / 1e6
            return of_run(*args[:position], now_s if utc == "gmtime" else real_time.gmtime(now_s))
        return real(*args)

    return read


def _setter(name: str) -> Callable[..., None]:
    real: Callable[..., None] = getattr(real_time, name)

    def set_time(*args: Any) -> None:
        node = current_node()
        if node is not None:
            place = place_of(sys._getframe(1))
            raise RealTimeError(
                f"{place}: time.{name} in node {node.name} would set the machine's clock: a run has its own"
            )
        real(*args)

    return set_time


_REPLACEMENTS = {
    **{name: _setter(name) for name in ("clock_settime", "clock_settime_ns") if hasattr(time, name)},
    **{name: _moment_call(name, 0) for name in ("localtime", "gmtime", "ctime", "asctime")},
    "strftime": _moment_call("strftime", 1),
    **{
        name: _clock_by_id(name, name.endswith("_ns"))
        for name in ("clock_gettime", "clock_gettime_ns")
        if hasattr(time, name)
    },
    **{name: _clock(name) for name in _CLOCKS if hasattr(time, name)},
    **{f"{name}_ns": _clock_ns(name) for name in _CLOCKS if hasattr(time, name)},
}

TIME_FUNCTIONS = tuple((getattr(time, name), other) for name, other in _REPLACEMENTS.items())
"""Functions of `time` but `sleep`, and what takes the place of each in runs."""

_IDENTIFIERS = {"uuid1": uuid1, "uuid4": uuid4, "uuid6": uuid6, "uuid7": uuid7}

MODULES = (stand_in(uuid, {name: function for name, function in _IDENTIFIERS.items() if hasattr(uuid, name)}),)
"""The modules that the code under test sees."""
