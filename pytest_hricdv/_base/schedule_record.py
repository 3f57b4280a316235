"""`ScheduleData`: a schedule in replay files and reports; runs use the objects of `generate.schedule`."""

from __future__ import annotations

from typing import Literal

from pytest_hricdv._base.record import Count, NotNegative, PlainRecord

DecisionKind = Literal["preemption", "delay", "order", "delivery"]

FailureKind = Literal["", "wrong-order", "late", "deadlock"]
"""Why a test fails with its schedule: the order of two threads; a delay alone; threads that wait for locks of each
other. Empty if no schedule was searched for."""


class DecisionData(PlainRecord, frozen=True, kw_only=True):
    """One decision in JSON.

    Args:
        kind: the kind of the decision, see `ScheduleDecision`.
        file: the statement's file, from the folder of its package; none of an order or a delivery.
        is_between: whether the node waits between reading and writing of the statement, not before it.
        node: the node that waited or sent the message, where it is known; nothing depends on it.
        occurrence: see `ScheduleDecision`.
        delay_s: likewise (s).
        choice: likewise.
    """

    kind: DecisionKind
    file: str = ""
    line: Count = 0
    is_between: bool = False
    topic: str = ""
    node: str = ""
    occurrence: Count
    delay_s: NotNegative = 0.0
    choice: Count = 0


class ScheduleData(PlainRecord, frozen=True, kw_only=True):
    """A schedule in JSON: its decisions."""

    decisions: tuple[DecisionData, ...] = ()
