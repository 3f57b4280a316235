"""Pairs: statements of different threads that access the same data, in the order in which a run executes them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from pytest_hricdv._base.record import Count, NotNegative, PlainRecord
from pytest_hricdv.extra.schedules.points import DataAccess
from pytest_hricdv.extra.schedules.scheduler import PointStep

MOST_OF_A_PAIR = 8
"""Number of executions kept of a pair: the first ones, then increasingly fewer."""


class DataConflict(PlainRecord, frozen=True, kw_only=True):
    """Two executions by different threads with the same data, one right after the other as far as the data goes.

    Args:
        first: place of the statement that came first.
        number: which execution of it this was, from 1.
        second: place of the other one.
        time_s: when the first one came (s of simulated time).
        gap_s: how much later the second one came (s).
        previous: what the first one's thread executes before, and which execution of it that is: perhaps it takes a
            lock that the second one needs.
        next: likewise, what it executes next: the second one may come right after the first one.
        is_in_one_node: both are tasks of one loop: neither goes on while the other one is held up.
        awaited: what another node executes before the first one's task goes on, and which execution of it that is.
    """

    first: str
    number: Count
    second: str
    time_s: NotNegative
    gap_s: NotNegative
    previous: tuple[str, Count] | None = None
    next: tuple[str, Count] | None = None
    is_in_one_node: bool = False
    awaited: tuple[str, Count] | None = None

    @property
    def pair(self) -> tuple[str, str]:
        """Both places, in this order."""
        return self.first, self.second

    @property
    def second_s(self) -> float:
        """When the second one came (s)."""
        return self.time_s + self.gap_s


def conflicts(
    steps: Sequence[PointStep], places: Sequence[str], accesses: Mapping[str, DataAccess]
) -> Iterator[DataConflict]:
    """Of what a run executed, in this order; of each thread, what it executed last with the same data, at one instant.

    Args:
        steps: what it executed.
        places: of points, by their numbers.
        accesses: place -> what its statement reads and writes.
    """
    neighbours = _neighbours(steps)

    def execution(index: int | None) -> tuple[str, int] | None:
        return None if index is None else (places[steps[index].point], steps[index].number)

    last: dict[str, dict[int, list[int]]] = {}
    for index, step in enumerate(steps):
        place = places[step.point]
        access = accesses[place]
        found: dict[tuple[str, int], int] = {}
        for name in access.reads | access.writes:
            of_name = last.setdefault(name, {})
            for earlier in (earlier for thread in of_name if thread != step.thread for earlier in of_name[thread]):
                before = steps[earlier]
                if name in access.writes or name in accesses[places[before.point]].writes:
                    found[places[before.point], before.number] = earlier
            at_once = (other for other in of_name.get(step.thread, ()) if steps[other].time_s == step.time_s)
            of_name[step.thread] = [*(other for other in at_once if steps[other].point != step.point), index]
        for earlier in found.values():
            before, is_in_one_node = steps[earlier], steps[earlier].node == step.node
            previous, following = neighbours[earlier]
            yield DataConflict(
                first=places[before.point],
                number=before.number,
                second=place,
                time_s=round(before.time_s, 6),
                gap_s=round(step.time_s - before.time_s, 6),
                previous=execution(previous),
                next=execution(following),
                is_in_one_node=is_in_one_node,
                awaited=_find_awaited(steps, places, earlier) if is_in_one_node else None,
            )


def _neighbours(steps: Sequence[PointStep]) -> list[tuple[int | None, int | None]]:
    """Of each step, the indices of the one before it and of the next one of its thread."""
    before: list[int | None] = []
    after: list[int | None] = [None] * len(steps)
    last: dict[int, int] = {}
    for index, step in enumerate(steps):
        previous = last.get(step.thread)
        before.append(previous)
        if previous is not None:
            after[previous] = index
        last[step.thread] = index
    return [*zip(before, after, strict=True)]


def _find_awaited(steps: Sequence[PointStep], places: Sequence[str], first: int) -> tuple[str, int] | None:
    """What another node executes before a task goes on; None where it is not the next one to execute anything."""
    for step in steps[first + 1 :]:
        if step.node != steps[first].node:
            return places[step.point], step.number
        if step.thread != steps[first].thread:
            return None
    return None


def thin(found: Iterator[DataConflict]) -> tuple[DataConflict, ...]:
    """A few of each pair: of many the 1st, 2nd, 4th, 8th, ..., and those with the smallest gaps."""
    kept: dict[tuple[str, str], list[DataConflict]] = {}
    seen: dict[tuple[str, str], int] = {}
    for conflict in found:
        count = seen[conflict.pair] = seen.get(conflict.pair, 0) + 1
        of_pair = kept.setdefault(conflict.pair, [])
        if count & (count - 1) == 0 or conflict.gap_s < max(other.gap_s for other in of_pair):
            of_pair.append(conflict)
        if len(of_pair) > MOST_OF_A_PAIR:
            of_pair.remove(max(of_pair, key=lambda other: other.gap_s))
    return tuple(conflict for pair in sorted(kept) for conflict in kept[pair])
