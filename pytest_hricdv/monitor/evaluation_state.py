"""What a compiled formula reads: the last values, the messages of the instant, the outputs of the operators.

A formula has a value *at* an instant and one *right after* it, which is valid until the next instant at which anything
changes. The two differ where messages and edges are concerned. Because both are kept, verdicts do not depend on how
finely a run is sampled.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Set
from dataclasses import dataclass, field

NS_PER_S = 1_000_000_000

# Time inside the monitors: whole nanoseconds, or infinity. The type is float because int has no infinity.
Nanoseconds = float

NO_MESSAGE: frozenset[str] = frozenset()


class UnknownValueError(LookupError):
    """A formula read a signal or field that has no value yet. Internal: becomes a `MonitorError` with the time."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.name = name


Value = float | bool | str


class Values(dict[str, Value]):
    """Last value of each signal and field, shared by the monitors of a run; the name of a field is `topic.field`."""

    def __missing__(self, name: str) -> Value:
        raise UnknownValueError(name)


class Outputs(dict[int, bool]):
    """The output of each stateful operator of one monitor, by its number in the program."""

    def __init__(self) -> None:
        super().__init__()
        self.unknown: dict[int, str] = {}  # operator -> the name without a value that keeps it from starting

    def __missing__(self, index: int) -> bool:
        raise UnknownValueError(self.unknown[index])


@dataclass(slots=True)
class EvaluationState:
    """The present instant for one monitor.

    Attributes:
        values: shared by all monitors of the run.
        arrived: topics of which a message arrived at this instant; shared by all monitors of the run.
        at: outputs of the operators at the instant.
        after: outputs right after it.
        before: outputs just before it.
    """

    values: Values
    arrived: Set[str]
    at: Outputs = field(default_factory=Outputs)
    after: Outputs = field(default_factory=Outputs)
    before: Outputs = field(default_factory=Outputs)

    def values_before(self) -> Values:
        """The values just before the instant at which an operator starts.

        The first value of a signal, a number or a bool is taken to have been there before: it is no edge. A text of a
        message of this instant was not there: its first value is an edge, as the message is.
        """
        return Values({name: value for name, value in self.values.items() if not self._is_new_text(name, value)})

    def _is_new_text(self, name: str, value: Value) -> bool:
        topic, dot, _ = name.partition(".")
        return isinstance(value, str) and dot != "" and topic in self.arrived


Condition = Callable[[Values, Set[str], Outputs], bool]
Robustness = Callable[[Values, Set[str], Outputs], float]


def nanoseconds(time_s: float) -> Nanoseconds:
    """Seconds to whole nanoseconds, so that a computed deadline equals the time of an update at that deadline.

    A time that is not finite is returned as it is.
    """
    return round(time_s * NS_PER_S) if math.isfinite(time_s) else time_s


def seconds(time_ns: Nanoseconds) -> float:
    """Whole nanoseconds to the nearest float in seconds."""
    return time_ns / NS_PER_S
