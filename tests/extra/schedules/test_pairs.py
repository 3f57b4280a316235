"""Pairs of statements of different threads on the same data."""

from __future__ import annotations

from pytest_hricdv.extra.schedules.pairs import MOST_OF_A_PAIR, DataConflict, conflicts, thin
from pytest_hricdv.extra.schedules.points import DataAccess
from pytest_hricdv.extra.schedules.scheduler import PointStep

PLACES = ["check", "act", "stop", "other"]
ACCESSES = {
    "check": DataAccess(reads=frozenset({".stopped"})),
    "act": DataAccess(writes=frozenset({".motor"})),
    "stop": DataAccess(writes=frozenset({".stopped", ".motor"})),
    "other": DataAccess(reads=frozenset({".else"})),
}


def step(place: str, thread: int, time_s: float, number: int = 1, node: int | None = None) -> PointStep:
    return PointStep(PLACES.index(place), number, thread, thread if node is None else node, time_s)


def found(*steps: PointStep) -> list[tuple[str, str, float]]:
    return [(entry.first, entry.second, entry.gap_s) for entry in conflicts(steps, PLACES, ACCESSES)]


def test_what_one_thread_reads_and_another_one_then_writes_is_a_pair() -> None:
    steps = step("check", 0, 1.0), step("act", 0, 1.0), step("other", 1, 1.1), step("stop", 1, 1.2)
    assert sorted(found(*steps)) == [("act", "stop", 0.2), ("check", "stop", 0.2)]
    assert found(step("stop", 1, 0.5), *steps)[0] == ("stop", "check", 0.5)


def test_one_thread_alone_and_two_that_only_read_are_none() -> None:
    assert found(step("act", 0, 1.0), step("act", 0, 2.0)) == []
    assert found(step("check", 0, 1.0), step("check", 1, 2.0)) == []


def test_only_the_last_one_of_a_thread_counts() -> None:
    assert found(step("act", 0, 1.0), step("act", 0, 2.0, number=2), step("stop", 1, 2.5)) == [("act", "stop", 0.5)]


def test_tasks_of_one_loop_are_threads_in_one_node() -> None:
    (conflict,) = conflicts([step("act", 0, 1.0, node=0), step("stop", 1, 1.0, node=0)], PLACES, ACCESSES)
    assert conflict.is_in_one_node


def test_of_a_thread_all_that_it_did_with_the_data_at_one_instant_counts() -> None:
    steps = step("stop", 0, 1.0), step("act", 0, 1.0), step("act", 1, 1.2)
    assert found(*steps) == [("stop", "act", 0.2), ("act", "act", 0.2)]
    assert found(step("stop", 0, 0.9), *steps[1:]) == [("act", "act", 0.2)]


def test_a_pair_knows_what_its_first_thread_executes_around_it() -> None:
    steps = step("other", 0, 1.0), step("check", 0, 1.0), step("stop", 1, 1.1), step("act", 0, 1.2, number=4)
    pair = next(conflicts(steps, PLACES, ACCESSES))
    assert (pair.first, pair.second) == ("check", "stop")
    assert (pair.previous, pair.next) == (("other", 1), ("act", 4))


def test_what_a_task_awaits_is_what_another_node_executes_next() -> None:
    checks, stops = step("check", 0, 1.0, node=0), step("stop", 1, 1.5, node=0)
    (pair,) = conflicts([checks, step("other", 2, 1.0, number=3, node=7), stops], PLACES, ACCESSES)
    assert pair.awaited == ("other", 3)
    (pair,) = conflicts([checks, step("other", 3, 1.0, node=0), step("other", 2, 1.0, node=7), stops], PLACES, ACCESSES)
    assert pair.awaited is None


def test_of_many_a_few_are_kept_with_the_smallest_gaps() -> None:
    many = (
        DataConflict(first="a", number=number, second="b", time_s=float(number), gap_s=abs(number - 50) / 10)
        for number in range(1, 200)
    )
    kept = thin(many)
    assert len(kept) == MOST_OF_A_PAIR
    assert min(conflict.gap_s for conflict in kept) == 0.0
