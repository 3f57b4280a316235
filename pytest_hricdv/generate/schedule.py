"""Schedules: the order in which nodes of the code under test proceed, as parameters of a concrete test.

Without decisions, nodes continue in the order in which they began to wait, and code takes no time. A decision changes
one thing about this.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

from pytest_hricdv.generate import GenerateError

EACH_TIME = 0
"""The number of a decision that holds for each execution of its statement."""

Kind = Literal["hold", "delay", "order", "delivery"]


@dataclass(frozen=True)
class ScheduleDecision:
    """One decision.

    Args:
        kind: `hold`: before the statement, the node waits until another node of the code has run, at most as long as
            the code may be slow. `delay`: before the statement, it waits for a fixed time. `order`: of the nodes that
            are ready, or wait for a lock or a queue, not the first one continues. `delivery`: a message arrives
            later; those with its sender and topic stay in order.
        place: of the statement, `file:line`; of a delivery, the topic; empty for `order`.
        number: which execution of the statement, message of the topic, or choice of the run, from 1; or `EACH_TIME`.
        value: of a hold, at most how long (s); of a delay or delivery, how long (s); of an order, which node, from 0.
    """

    kind: Kind
    place: str
    number: int
    value: float = 0.0

    def to_data(self) -> list[Any]:
        """For JSON."""
        return [self.kind, self.place, self.number, self.value]


def schedule_from_data(data: Sequence[Any]) -> tuple[ScheduleDecision, ...]:
    """Build a schedule from the data that `to_data` gave for each decision.

    Raises:
        GenerateError: it is no such list.
    """
    decisions = []
    for entry in data:
        match [*entry]:
            case ["hold" | "delay" | "order" | "delivery" as kind, str(place), int(number), int(value) | float(value)]:
                decisions.append(ScheduleDecision(kind, place, number, float(value)))
            case _:
                raise GenerateError(
                    f"no decision of a schedule: {entry!r}; expected [kind, place, number, value], "
                    "the kind hold, delay, order or delivery"
                )
    return tuple(decisions)
