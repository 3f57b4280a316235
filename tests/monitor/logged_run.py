"""A logged run in whole ticks, for evaluators to compare.

Time is in whole ticks. A run is a sequence of positions: 0 is before the run, then instant, open interval, instant, ...
up to the last instant. Updates are at whole ticks, so nothing changes inside an open interval.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

TICK_S = 0.25
Value = float | bool | str


@dataclass(frozen=True)
class Instant:
    """The updates of one tick: signals first."""

    signals: Mapping[str, Value] = field(default_factory=dict)
    messages: tuple[tuple[str, Mapping[str, Value]], ...] = ()


@dataclass(frozen=True)
class LoggedRun:
    """A logged run: tick -> its updates; tick 0 updates every signal."""

    instants: Mapping[int, Instant]
    last: int


def tick_of(position: int) -> int:
    return (position - 1) // 2


def first_position(tick: float) -> int:
    return 1 + 2 * round(tick)
