"""`EvaluationState`, which compiled formulas read: last values, messages of the instant, outputs of operators.

Each monitor of a run has one; the last values and the messages are shared. A formula has a value *at* an instant and
one *right after* it, which holds until the next instant at which anything changes. They differ for messages and edges.
Keeping both makes verdicts independent of the sampling rate of a run.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from pytest_hricdv.monitor.node import field_of, is_optional, last_of

NS_PER_S = 1_000_000_000
"""Nanoseconds, the monitors' unit of time, in a second: finer than the kernel's microseconds, so that rounding never
merges two instants of a run."""

LAST_NS = 2**62
"""The latest time of a run (ns), 146 years: twice this number still fits a 64-bit column."""

# Time inside the monitors: whole nanoseconds, or infinity. The type is float because int has no infinity.
Nanoseconds = float

NO_MESSAGE: Mapping[str, int] = {}
"""`EvaluationState.arrived` without messages, as right before and after an instant."""


class UnknownValueError(LookupError):
    """A formula read a signal or field that has no value yet. Internal: becomes a `MonitorError` with the time."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.name = name


Value = float | bool | str
"""A value of a signal or of a message's field, as requirements read it."""


class Values(dict[str, Value]):
    """Last value of each signal and field, shared by the monitors of a run; the name of a field is `topic.field`."""

    def __missing__(self, name: str) -> Value:
        raise UnknownValueError(name)

    def set_field(self, field: str, value: Value, *, keep_last: bool) -> None:
        """Set `topic.field` to the value of a new message; with `keep_last`, the previous value is kept as well."""
        if keep_last and field in self:  # the first message has no previous value
            self[last_of(field)] = self[field]
        self[field] = value


class Outputs(dict[int, float | None]):
    """The output of each stateful operator of one monitor, by its number in the program: a truth value or a number.

    None stands for a number that does not exist yet.
    """

    def __init__(self) -> None:
        super().__init__()
        self.unknown: dict[int, str] = {}  # operator -> the name whose missing value keeps it from starting

    def __missing__(self, index: int) -> float | None:
        raise UnknownValueError(self.unknown[index])


@dataclass(slots=True)
class EvaluationState:
    """The current instant, as one monitor sees it.

    Attributes:
        values: shared by all monitors of the run.
        arrived: topic -> how many of its messages arrived at this instant; shared by all monitors of the run.
        at: outputs of the operators at the instant.
        after: outputs right after it.
        before: outputs just before it.
    """

    values: Values
    arrived: Mapping[str, int]
    at: Outputs = field(default_factory=Outputs)
    after: Outputs = field(default_factory=Outputs)
    before: Outputs = field(default_factory=Outputs)

    def values_before(self) -> Values:
        """The values just before the instant at which an operator starts.

        A first value counts as present before, so it is not an edge. A value that may be unknown without an error, such
        as a string field, counts as new with the messages of this instant, so it is an edge, as they are.
        """
        return Values({name: value for name, value in self.values.items() if not self._is_new(name, value)})

    def _is_new(self, name: str, value: Value) -> bool:
        return is_optional(name, type(value)) and field_of(name).partition(".")[0] in self.arrived


Condition = Callable[[Values, Mapping[str, int], Outputs], bool]
Measure = Callable[[Values, Mapping[str, int], Outputs], float]


def nanoseconds(time_s: float) -> Nanoseconds:
    """Seconds to whole nanoseconds, so that a computed deadline equals the time of an update at that deadline.

    A time that is not finite is returned unchanged.
    """
    return round(time_s * NS_PER_S) if math.isfinite(time_s) else time_s


def seconds(time_ns: Nanoseconds) -> float:
    """Whole nanoseconds to the nearest float in seconds."""
    return time_ns / NS_PER_S
