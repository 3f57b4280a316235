"""Pairs of statements of different threads on the same data."""

from __future__ import annotations

from collections.abc import Sequence

from pytest_hricdv.extra.schedules.pairs import MOST_OF_A_PAIR, DataConflict, ExecutedSteps
from pytest_hricdv.extra.schedules.points import DataAccess
from pytest_hricdv.extra.schedules.scheduler import PointStep

PLACES = ["check", "act", "stop", "other"]
ACCESSES = {
    "check": DataAccess(reads=frozenset({".stopped"})),
    "act": DataAccess(writes=frozenset({".motor"})),
    "stop": DataAccess(writes=frozenset({".stopped", ".motor"})),
    "other": DataAccess(reads=frozenset({".else"})),
}


def step(place: str, thread: int, time_s: float) -> PointStep:
    return PLACES.index(place), thread, round(time_s * 1e6)


def pairs(*steps: PointStep, nodes: Sequence[int] = range(9)) -> tuple[DataConflict, ...]:
    return ExecutedSteps(steps, nodes, PLACES, ACCESSES).conflicts()


def found(*steps: PointStep) -> list[tuple[str, str, float]]:
    return [(entry.first, entry.second, entry.gap_s) for entry in pairs(*steps)]


def test_what_one_thread_reads_and_another_one_then_writes_is_a_pair() -> None:
    steps = step("check", 0, 1.0), step("act", 0, 1.0), step("other", 1, 1.1), step("stop", 1, 1.2)
    assert found(*steps) == [("act", "stop", 0.2), ("check", "stop", 0.2)]
    assert ("stop", "check", 0.5) in found(step("stop", 1, 0.5), *steps)


def test_one_thread_alone_and_two_that_only_read_are_none() -> None:
    assert found(step("act", 0, 1.0), step("act", 0, 2.0)) == []
    assert found(step("check", 0, 1.0), step("check", 1, 2.0)) == []


def test_only_the_last_one_of_a_thread_counts() -> None:
    assert found(step("act", 0, 1.0), step("act", 0, 2.0), step("stop", 1, 2.5)) == [("act", "stop", 0.5)]


def test_tasks_of_one_loop_are_threads_in_one_node() -> None:
    (conflict,) = pairs(step("act", 0, 1.0), step("stop", 1, 1.0), nodes=(0, 0))
    assert conflict.is_in_one_node


def test_of_a_thread_all_that_it_did_with_the_data_at_one_instant_counts() -> None:
    steps = step("stop", 0, 1.0), step("act", 0, 1.0), step("act", 1, 1.2)
    assert found(*steps) == [("act", "act", 0.2), ("stop", "act", 0.2)]
    assert found(step("stop", 0, 0.9), *steps[1:]) == [("act", "act", 0.2)]


def test_a_pair_knows_what_its_first_thread_executes_around_it() -> None:
    steps = step("other", 0, 1.0), step("check", 0, 1.0), step("stop", 1, 1.1), step("act", 0, 1.2)
    pair = next(entry for entry in pairs(*steps) if entry.pair == ("check", "stop"))
    assert (pair.previous, pair.next) == (("other", 1), ("act", 1))


def test_what_a_task_awaits_is_what_another_node_executes_next() -> None:
    checks, other, stops = step("check", 0, 1.0), step("other", 2, 1.0), step("stop", 1, 1.5)
    (pair,) = pairs(checks, other, stops, nodes=(0, 0, 7))
    assert pair.awaited == ("other", 1)
    (pair,) = pairs(checks, step("other", 3, 1.0), other, stops, nodes=(0, 0, 7, 0))
    assert pair.awaited is None


def test_of_many_a_few_are_kept_with_the_smallest_gaps() -> None:
    steps = (
        entry
        for number in range(1, 200)
        for entry in (step("check", 0, number), step("stop", 1, number + (1 + abs(number - 50)) / 1000))
    )
    kept = [pair for pair in pairs(*steps) if pair.pair == ("check", "stop")]
    assert len(kept) == MOST_OF_A_PAIR
    assert min(pair.gap_s for pair in kept) == 0.001


def test_data_that_one_thread_accesses_costs_nothing() -> None:
    assert found(step("act", 0, 1.0), step("check", 1, 1.0)) == []
