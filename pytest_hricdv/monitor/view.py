"""What a compiled formula reads: the last values, the messages of the instant, what the past operators say.

A formula has a value *at* an instant and one *right after* it, which lasts until the next instant at which anything
changes. The two differ where messages and edges are concerned, and keeping both is what makes verdicts independent of
how finely a run is sampled.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Set
from dataclasses import dataclass, field

from pytest_hricdv.monitor.errors import UnknownValueError

NS_PER_S = 1_000_000_000

# Time inside the monitors: whole nanoseconds, or infinity; a float only so that infinity has a place in the type.
Nanoseconds = float

NO_MESSAGE: frozenset[str] = frozenset()


class Values(dict[str, "float | bool"]):
    """Last value of each signal and field, shared by the monitors of a run; a field is `topic.field`."""

    def __missing__(self, name: str) -> float | bool:
        raise UnknownValueError(name)


class Outputs(dict[int, bool]):
    """What each stateful operator of one monitor says, by its number in the program."""

    def __init__(self) -> None:
        super().__init__()
        self.unknown: dict[int, str] = {}  # operator -> the name for want of which it has not begun

    def __missing__(self, index: int) -> bool:
        raise UnknownValueError(self.unknown[index])


@dataclass(slots=True)
class View:
    """The present instant as one monitor sees it.

    Attributes:
        values: shared by all monitors of the run.
        arrived: topics of which a message arrived at this instant; shared by all monitors of the run.
        at: what the operators say at the instant.
        after: what they say right after it.
        before: what they said just before it.
    """

    values: Values
    arrived: Set[str]
    at: Outputs = field(default_factory=Outputs)
    after: Outputs = field(default_factory=Outputs)
    before: Outputs = field(default_factory=Outputs)


Condition = Callable[[Values, Set[str], Outputs], bool]
Robustness = Callable[[Values, Set[str], Outputs], float]


def nanoseconds(time_s: float) -> Nanoseconds:
    """Seconds to whole nanoseconds: so a computed deadline equals the time of an update that comes just then."""
    return time_s if math.isinf(time_s) else round(time_s * NS_PER_S)


def seconds(time_ns: Nanoseconds) -> float:
    """Whole nanoseconds to the nearest float in seconds."""
    return time_ns / NS_PER_S
