"""`time` and `datetime` in virtual time. Outside of a node each function is the real one."""

from __future__ import annotations

import datetime as real_datetime
import time as real_time
from collections.abc import Callable
from typing import Any

from pytest_hricdv.runtime.blocking_calls import TIME
from pytest_hricdv.runtime.kernel import running_node
from pytest_hricdv.runtime.virtual.copies import stand_in
from pytest_hricdv.runtime.virtual.real_time import check

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

EPOCH = real_datetime.datetime(2000, 1, 1, tzinfo=real_datetime.UTC)
"""The date of the beginning of each run: the same in each of them (chosen)."""

_CLOCKS = ("time", "monotonic", "perf_counter", "process_time", "thread_time")
_NS_PER_S = 1_000_000_000


def monotonic() -> float:
    """The time of the run (s), whatever the testbench says: what waits in virtual time measures its time-outs so."""
    node = running_node()
    return real_time.monotonic() if node is None else node.kernel.now_s


def sleep(duration_s: float) -> None:
    """As `time.sleep`."""
    node = running_node()
    if node is None:
        real_time.sleep(duration_s)  # outside of a run, time is real
        return
    check(node, TIME, "time.sleep")
    node.kernel.sleep(duration_s)


def _now_us(name: str) -> int | None:
    """The time of the run; None outside of a node."""
    node = running_node()
    if node is None:
        return None
    check(node, TIME, name)
    node.kernel.count_poll()
    return node.kernel.now_us


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


class _LikeDatetime(type):
    """Of a class whose instances are all moments, also those that it did not make: `isinstance` is as without it."""

    def __instancecheck__(cls, instance: object) -> bool:
        return isinstance(instance, real_datetime.datetime)


class _LikeDate(type):
    """The same of days."""

    def __instancecheck__(cls, instance: object) -> bool:
        return isinstance(instance, real_datetime.date)


def _moment(name: str, tz: real_datetime.tzinfo | None) -> real_datetime.datetime:
    now_us = _now_us(name)
    if now_us is None:
        return real_datetime.datetime.now(tz)
    moment = EPOCH + real_datetime.timedelta(microseconds=now_us)
    return moment.astimezone(tz) if tz is not None else moment.replace(tzinfo=None)


class VirtualDatetime(real_datetime.datetime, metaclass=_LikeDatetime):
    """A moment whose present is that of the run."""

    @classmethod
    def now(cls, tz: real_datetime.tzinfo | None = None) -> Any:
        """As of `datetime.datetime`."""
        return _moment("datetime.now", tz)

    @classmethod
    def utcnow(cls) -> Any:
        """As of `datetime.datetime`."""
        return _moment("datetime.utcnow", None)

    @classmethod
    def today(cls) -> Any:
        """As of `datetime.datetime`."""
        return _moment("datetime.today", None)


class VirtualDate(real_datetime.date, metaclass=_LikeDate):
    """A day whose present is that of the run."""

    @classmethod
    def today(cls) -> Any:
        """As of `datetime.date`."""
        return _moment("date.today", None).date()


def _named(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
    function.__name__ = name
    return function


_TIME = {"sleep": sleep}
_TIME |= {name: _named(name, _clock(name)) for name in _CLOCKS if hasattr(real_time, name)}
_TIME |= {f"{name}_ns": _named(f"{name}_ns", _clock_ns(name)) for name in _CLOCKS if hasattr(real_time, name)}

MODULES = (
    stand_in(real_time, _TIME),
    stand_in(real_datetime, {"datetime": VirtualDatetime, "date": VirtualDate}),
)
"""What the modules under test see."""
