"""Schedules: the order in which nodes of the code under test proceed, as parameters of a concrete test.

A schedule is a tuple of `ScheduleDecision`. Without one, nodes continue in the order in which they began to wait, and
code takes no time; each decision changes one thing about this. The feature `schedules` searches for decisions with
which a test fails; `schedule_to_data` writes them for reports and replay files, `schedule_from_data` reads them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import get_args

from msgspec.structs import replace

from pytest_hricdv._base.schedule_record import DecisionData, DecisionKind, ScheduleData
from pytest_hricdv.generate import GenerateError

EACH_TIME = 0
"""As the occurrence of a decision: it applies to each execution of its statement."""

WRITES = "="
"""Suffix of a place (`file:line=`): within an assignment such as `n += 1`, after reading and before writing."""


@dataclass(frozen=True)
class ScheduleDecision:
    """One decision.

    Args:
        kind: `preemption`: before the statement, the node waits until another node of the code has run, at most as long
            as the code may be slow. `delay`: before the statement, it waits for a fixed time. `order`: of the nodes
            that are ready, or wait for a lock or a queue, another one than the first goes on. `delivery`: a message
            arrives later; those with its sender and topic stay in order.
        place: the statement's place, `file:line`; of a delivery, the topic; empty for `order`.
        occurrence: which execution of the statement, message of the topic, or choice of the run, from 1; or
            `EACH_TIME`.
        delay_s: maximum length of a preemption, or length of a delay or delivery (s).
        choice: for an order, the index of the node that continues.
        node: the node that waited or sent the message; nothing depends on it.

    Raises:
        GenerateError: there is no such kind, or a number is negative or not finite.
    """

    kind: DecisionKind
    place: str
    occurrence: int
    delay_s: float = 0.0
    choice: int = 0
    node: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        kinds = get_args(DecisionKind)
        if self.kind not in kinds:
            raise GenerateError(f"a decision of a schedule is {self.kind!r}; expected {', '.join(kinds)}")
        for name in ("occurrence", "delay_s", "choice"):
            if not 0 <= getattr(self, name) < math.inf:
                raise GenerateError(f"{self}: {name} is {getattr(self, name)}; expected a finite number, at least 0")

    def to_data(self) -> DecisionData:
        """For JSON."""
        whole = DecisionData(
            kind=self.kind, node=self.node, occurrence=self.occurrence, delay_s=self.delay_s, choice=self.choice
        )
        match self.kind:
            case "order":
                return whole
            case "delivery":
                return replace(whole, topic=self.place)
            case _:
                file, _, line = self.place.removesuffix(WRITES).rpartition(":")
                return replace(whole, file=file, line=int(line), is_between=self.place.endswith(WRITES))


def schedule_to_data(schedule: Iterable[ScheduleDecision]) -> ScheduleData | None:
    """A schedule for JSON; None for the usual order."""
    decisions = tuple(decision.to_data() for decision in schedule)
    return ScheduleData(decisions=decisions) if decisions else None


def schedule_from_data(data: ScheduleData | None) -> tuple[ScheduleDecision, ...]:
    """The schedule that `schedule_to_data` gave.

    Raises:
        GenerateError: a decision lacks what its kind needs.
    """
    return tuple(map(_decision, data.decisions if data is not None else ()))


def _decision(data: DecisionData) -> ScheduleDecision:
    statement = f"{data.file}:{data.line}{WRITES * data.is_between}" if data.file and data.line else ""
    place = {"order": "", "delivery": data.topic}.get(data.kind, statement)
    if not (data.choice if data.kind == "order" else place):
        lacks = {"order": "choice", "delivery": "topic"}.get(data.kind, "file and line")
        raise GenerateError(f"a decision of a schedule, {data.kind}, lacks its {lacks}")
    return ScheduleDecision(data.kind, place, data.occurrence, float(data.delay_s), data.choice, data.node)
