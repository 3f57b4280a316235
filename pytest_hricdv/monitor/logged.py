"""Verdicts on a logged run: the log is fed to the monitors, in the order of time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Real

from pytest_hricdv.monitor.analysis import names_read, topics_read
from pytest_hricdv.monitor.evaluation_state import seconds
from pytest_hricdv.monitor.log import Log
from pytest_hricdv.monitor.monitor_set import MonitorError, MonitorSet
from pytest_hricdv.monitor.near_miss import explained
from pytest_hricdv.monitor.requirement import Kind, Requirement
from pytest_hricdv.monitor.verdict import Verdict


def evaluate(requirements: Sequence[Requirement], log: Log) -> tuple[Verdict, ...]:
    """The verdicts on a logged run, in the order of the requirements; those that were not triggered are explained.

    Raises:
        MonitorError: as from a `MonitorSet`; or a signal of the log has not one value for each time, or a bool is
            neither 0 nor 1.
    """
    kinds: dict[str, Kind] = {}
    topics: set[str] = set()
    for requirement in requirements:
        kinds.update({**dict.fromkeys(requirement.shows, float), **names_read(requirement.formula)})
        topics |= topics_read(requirement.formula)
    signals = [name for name in kinds if "." not in name]
    for name in signals:
        _require_one_value_each(name, *log.signals.get(name, ((), ())))
    monitors = MonitorSet(requirements)
    for now_ns, updates in log.instants(signals, topics):
        time_s = seconds(now_ns)
        monitors.advance(time_s)
        for name, value in updates:
            if isinstance(value, Mapping):
                monitors.message(time_s, name, value)
            else:
                monitors.signal(time_s, name, _typed(time_s, name, value, kinds[name]))
    return explained(monitors.finish(log.end_s), requirements, log)


def _require_one_value_each(name: str, times: Sequence[float], values: Sequence[float]) -> None:
    if len(times) != len(values):
        raise MonitorError(f"{name}: expected one value for each of {len(times)} times, got {len(values)} values")


def _typed(time_s: float, name: str, value: float | bool, kind: Kind) -> float | bool:
    """The value as the monitors want it: a log may have a bool as a number, and numbers of other libraries."""
    if kind is bool:
        if value not in (0, 1):
            raise MonitorError(f"{name} at {time_s} s is {value!r}: not a bool")
        return bool(value)
    return float(value) if isinstance(value, Real) else value
