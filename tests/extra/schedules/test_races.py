"""Races: the fewest decisions, and order told from delay."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from pytest_hricdv.extra.schedules.races import RaceExamination, ScheduleRace, is_other_order
from pytest_hricdv.extra.schedules.schedule_run import ScheduleRun, pack_steps
from pytest_hricdv.extra.schedules.scheduler import HeldNode
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest, Concretization
from pytest_hricdv.generate.schedule import ScheduleDecision

SPACE = Concretization(commands={"stop": {}})
USUAL = ScheduleRun(threads=2)


def hold(place: str, value: float = 0.05) -> ScheduleDecision:
    return ScheduleDecision("preemption", place, 1, value)


def examined(fails: Callable[[dict[str, ScheduleDecision]], bool], *decisions: ScheduleDecision) -> ScheduleRace:
    """A test in which the other node runs 0.02 s after each hold begins."""

    def run(test: ConcreteTest) -> ScheduleRun:
        at = {decision.place: decision for decision in test.schedule}
        held = tuple(
            HeldNode(
                place=entry.place,
                node="robot",
                time_s=1.0,
                for_s=min(entry.delay_s, 0.02) if entry.kind == "preemption" else entry.delay_s,
                between=(("guard.py:7", "guard"),) if entry.kind == "preemption" else (),
            )
            for entry in test.schedule
            if entry.kind != "order"
        )
        return ScheduleRun(violated=("R1",) if fails(at) else (), held=held)

    test = ConcreteTest("t", "suite", 0, (ConcreteAction("stop"),), schedule=decisions)
    examination = RaceExamination(run, lambda ran: "R1" in ran.fails, False)
    return examination.examine(test, run(test))


def test_what_fails_with_the_delay_alone_is_late_by_the_least_delay_that_does_it() -> None:
    race = examined(lambda at: at["a"].kind == "preemption" or at["a"].delay_s > 0.0125, hold("a"))
    assert race.kind == "late"
    assert abs(race.least_s - 0.0125) < 1e-4
    assert race.test.schedule[0].kind == "delay"


def test_what_fails_however_short_the_delay_is_another_order() -> None:
    assert examined(lambda at: True, hold("a")).kind == "wrong-order"
    assert examined(lambda at: at["a"].kind == "preemption" or at["a"].delay_s > 0.0, hold("a")).kind == "late"


@pytest.mark.parametrize(
    ("before", "after", "is_other"),
    [
        ("a1 a2 b1 a3", "a1 b1 a2 a3", True),
        ("a1 a2 a3 b1 b2", "a1 a2 b1 a3 b2", True),
        ("a1 a2 b1", "a1 a4 b1", False),  # another branch
        ("a1 a2 b1", "a1 b1 a4", False),
        ("a1 a2 b1", "a1 a2 b1", False),
    ],
)
def test_a_delay_with_which_threads_change_places_is_another_order(before: str, after: str, is_other: bool) -> None:
    first, second = (
        ScheduleRun(steps=pack_steps(("ab".index(step[0]), int(step[1])) for step in text.split()))
        for text in (before, after)
    )
    assert is_other_order(first, second) is is_other
