"""The search of schedules: what it draws before anything was found."""

from __future__ import annotations

from itertools import islice, pairwise

from msgspec.structs import replace

from pytest_hricdv.extra.schedules.pairs import DataConflict
from pytest_hricdv.extra.schedules.schedule_run import ScheduleRun
from pytest_hricdv.extra.schedules.search import TURNS, ScheduleCandidate, ScheduleSearch
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest, Concretization

PLACES = tuple(f"robot.py:{line}" for line in range(1, 6))
NEAR = tuple(
    DataConflict(first=first, number=1, second=second, step=1, time_s=1.0, gap_s=0.01)
    for first, second in pairwise(PLACES)
)
READY = tuple((2, place) for place in PLACES for _ in range(20))
"""Twenty choices at each place, one after the other."""


def draw(usual: ScheduleRun, runs: int) -> list[ConcreteTest]:
    test = ConcreteTest("t", "rl", 0, (ConcreteAction("stop", {}),), {})
    drawn = ScheduleSearch(0.05, 0).draw([ScheduleCandidate("t.py::t", test, Concretization(commands={}), usual)])
    return [test for _, test in islice(drawn, runs)]


def test_every_near_pair_is_reversed_soon() -> None:
    usual = ScheduleRun(threads=2, conflicts=NEAR, executed=dict.fromkeys(PLACES, 9))
    alone = {test.schedule[0].place for test in draw(usual, 2 * len(NEAR)) if len(test.schedule) == 1}
    assert alone >= {conflict.first for conflict in NEAR}


def test_a_hold_is_tried_once_for_all_pairs_that_begin_with_it() -> None:
    more = tuple(replace(NEAR[0], second=f"robot.py:{line}") for line in range(10, 40))
    usual = ScheduleRun(threads=2, conflicts=(*NEAR, *more), executed=dict.fromkeys(PLACES, 9))
    held = [[decision.place for decision in test.schedule] for test in draw(usual, len(NEAR))]
    assert sorted(held) == [[conflict.first] for conflict in NEAR]


def test_another_one_goes_first_at_each_place_soon() -> None:
    usual = ScheduleRun(threads=2, ready=READY)
    rounds = len(TURNS) * len(PLACES)
    chosen = {
        decision.occurrence for test in draw(usual, rounds) for decision in test.schedule if decision.kind == "order"
    }
    assert {READY[number - 1][1] for number in chosen} == set(PLACES)


def test_nothing_is_drawn_where_nothing_can_be_ordered() -> None:
    assert draw(ScheduleRun(threads=1, conflicts=NEAR), 1) == []
