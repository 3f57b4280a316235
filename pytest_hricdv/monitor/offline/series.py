"""The signals and messages of a log as numpy arrays: checked, in whole nanoseconds, with lookup at any times."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pytest_hricdv.monitor.errors import MonitorError
from pytest_hricdv.monitor.evaluation_state import NS_PER_S, Nanoseconds, seconds
from pytest_hricdv.monitor.log import Log
from pytest_hricdv.monitor.requirement import Kind

Times = NDArray[np.int64]


@dataclass(frozen=True)
class Series:
    """One signal or field: `values[i]` from `times[i]` on; of several values at one time, the last counts."""

    times: Times
    values: NDArray[np.float64]

    def known(self, times: Times) -> NDArray[np.bool_]:
        """Whether it has a value at each of the times."""
        return times >= self.times[0] if len(self.times) else np.zeros(len(times), bool)

    def at(self, times: Times) -> NDArray[np.float64]:
        """Its value at each of the times; 0 before the first."""
        if not len(self.times):
            return np.zeros(len(times))
        index = np.searchsorted(self.times, times, side="right") - 1
        return np.where(index < 0, 0.0, self.values[np.maximum(index, 0)])


class SeriesOfLog:
    """The signals and messages of a log that a requirement reads.

    Attributes:
        start_ns, end_ns: of the run.

    Raises:
        MonitorError: a time or a value is not a finite number, a bool is neither 0 nor 1, times go back, or a message
            lacks a field that is read.
    """

    def __init__(self, log: Log, kinds: Mapping[str, Kind], topics: Iterable[str]) -> None:
        self._kinds = kinds
        self.start_ns, self.end_ns = (int(time) for time in _nanoseconds("the run", [log.start_s, log.end_s]))
        self._series = {
            name: self._checked(name, *log.signals[name]) for name in kinds if "." not in name and name in log.signals
        }
        self._arrivals = {}
        for topic in topics:
            received = [message for message in log.messages if message.topic == topic]
            times = [message.time_s for message in received]
            self._arrivals[topic] = self._in_order(f"messages {topic!r}", times)
            for name in kinds:
                if name.startswith(f"{topic}."):
                    values = [_field(message.fields, topic, name, message.time_s) for message in received]
                    self._series[name] = self._checked(name, times, values)

    def of(self, name: str) -> Series | None:
        """A signal or field; None if it never had a value."""
        return self._series.get(name)

    def arrivals(self, topic: str) -> Times:
        """The times of the messages of a topic (ns)."""
        return self._arrivals[topic]

    def updates(self, source: str) -> Times:
        """The times of the updates of a source as of `analysis.source_of` (ns)."""
        if source.startswith("on("):
            return self._arrivals[source[3:-1]]
        series = self._series.get(source)
        return np.empty(0, np.int64) if series is None else series.times

    def values_at(self, names: Iterable[str], now_ns: Nanoseconds) -> dict[str, float | bool]:
        """The last value of each name that has a value at `now_ns`."""
        now = np.array([now_ns], np.int64)
        known = {name: series for name in names if (series := self._series.get(name)) and series.known(now)[0]}
        return {name: self._kinds[name](series.at(now)[0]) for name, series in known.items()}

    def extremes(self, names: Iterable[str], from_ns: Nanoseconds, to_ns: Nanoseconds) -> dict[str, float]:
        """For each name with a value at `from_ns`: the value with the largest absolute value up to `to_ns`."""
        found = {}
        for name, first in self.values_at(names, from_ns).items():
            series = self._series[name]
            lasts = np.diff(series.times, append=np.iinfo(np.int64).max) > 0
            within = series.values[lasts & (series.times > from_ns) & (series.times <= to_ns)]
            found[name] = max((first, *within.tolist()), key=abs)
        return found

    def _checked(self, name: str, times_s: Iterable[float], values: Iterable[object]) -> Series:
        times = self._in_order(name, times_s)
        array = np.asarray(values)
        if array.shape != times.shape or array.dtype.kind not in "biuf":
            raise MonitorError(f"{name}: expected {len(times)} numbers, one for each time, got {array!r:.80}")
        array = array.astype(np.float64)
        valid = np.isfinite(array)
        if self._kinds[name] is bool:
            valid &= (array == 0) | (array == 1)
        if not valid.all():
            first = int(np.argmin(valid))
            wanted = "a bool" if self._kinds[name] is bool else "a finite number"
            raise MonitorError(f"{name} at {seconds(int(times[first]))} s is {array[first]}: not {wanted}")
        return Series(times, array)

    def _in_order(self, what: str, times_s: Iterable[float]) -> Times:
        times = _nanoseconds(what, times_s)
        whole = np.concatenate(([self.start_ns], times, [self.end_ns]))
        back = np.flatnonzero(np.diff(whole) < 0)
        if len(back):
            later, earlier = seconds(int(whole[back[0]])), seconds(int(whole[back[0] + 1]))
            raise MonitorError(f"back in time: {what} at {earlier} s after {later} s")
        return times


def _nanoseconds(what: str, times_s: Iterable[float]) -> Times:
    times = np.asarray(times_s, np.float64)
    if not np.isfinite(times).all():
        raise MonitorError(f"{what}: a time has to be a finite number of seconds")
    return np.rint(times * NS_PER_S).astype(np.int64)


def _field(fields: Mapping[str, object], topic: str, name: str, time_s: float) -> object:
    field = name.partition(".")[2]
    if field not in fields:
        present = ", ".join(fields) or "none"
        raise MonitorError(f"a message {topic!r} at {time_s} s has no field {field!r}; its fields: {present}")
    return fields[field]
