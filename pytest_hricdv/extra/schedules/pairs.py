"""Pairs: statements of different threads that access the same data, in the order in which a run executes them.

`ExecutedSteps` finds them in what a run has executed, for `ScheduleWorker`. Each is a `DataConflict`; `ScheduleSearch`
looks for schedules that reverse their order.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from pytest_hricdv._base.record import Count, NotNegative, PlainRecord
from pytest_hricdv.extra.schedules.points import DataAccess
from pytest_hricdv.extra.schedules.scheduler import US_PER_S, PointStep

MOST_OF_A_PAIR = 8
"""Maximum number of executions of a pair that are kept: the first ones, then increasingly fewer."""


class DataConflict(PlainRecord, frozen=True, kw_only=True):
    """Two executions by different threads with the same data, one right after the other as far as the data goes.

    Args:
        first: place of the statement that came first.
        number: which execution of it this was, from 1.
        second: place of the other statement.
        step: number (from 0) of the first execution among the steps of the run.
        time_s: time of the first execution (s, simulated).
        gap_s: how much later the second one came (s).
        previous: what the first one's thread executes before, and which execution of it that is: perhaps it takes a
            lock that the second one needs.
        next: likewise, what it executes next: the second one may come right after the first one.
        is_in_one_node: whether both are tasks of one loop: neither continues while the other one is held up.
        awaited: what another node executes before the first one's task continues, and which execution of it that is.
    """

    first: str
    number: Count
    second: str
    step: Count
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


@dataclass
class ExecutedSteps:
    """The steps that the threads of a run executed, in this order.

    Args:
        nodes: thread number -> number of its node.
        places: the places of points, by their numbers.
        accesses: place -> what its statements read and write.
    """

    steps: Sequence[PointStep]
    nodes: Sequence[int]
    places: Sequence[str]
    accesses: Mapping[str, DataAccess]
    _numbers: list[int] = field(default_factory=list)
    """Of each step, which execution of its place it is, from 1."""

    def __post_init__(self) -> None:
        counts = [0] * len(self.places)
        self._of_threads: list[list[int]] = [[] for _ in self.nodes]
        for index, (point, thread, _) in enumerate(self.steps):
            counts[point] += 1
            self._numbers.append(counts[point])
            self._of_threads[thread].append(index)
        self.executed = {place: count for place, count in zip(self.places, counts, strict=True) if count}

    def conflicts(self) -> tuple[DataConflict, ...]:
        """A few of each pair of statements: of many the 1st, 2nd, 4th, 8th, ..., and those with the smallest gaps."""
        kept: dict[tuple[int, int], list[tuple[int, int, int]]] = {}
        counts: dict[tuple[int, int], int] = {}
        largest_us: dict[tuple[int, int], int] = {}
        steps = self.steps
        for first, second in self._pairs():
            (point, _, began_us), (other, _, ended_us) = steps[first], steps[second]
            pair, gap_us = (point, other), ended_us - began_us
            count = counts[pair] = counts.get(pair, 0) + 1
            if count & (count - 1) and gap_us >= largest_us[pair]:
                continue
            of_pair = kept.setdefault(pair, [])
            of_pair.append((gap_us, first, second))
            if len(of_pair) > MOST_OF_A_PAIR:
                of_pair.remove(max(of_pair))
            largest_us[pair] = max(of_pair)[0]
        conflicts = (self._conflict(*entry) for of_pair in kept.values() for entry in of_pair)
        return tuple(sorted(conflicts, key=lambda conflict: (conflict.pair, conflict.number, conflict.gap_s)))

    def _pairs(self) -> Iterator[tuple[int, int]]:
        """Indices of steps; of each thread, what it executed last with the same data, at one instant."""
        steps, shared = self.steps, self._common_data()
        data: dict[int, list[tuple[dict[int, list[int]], frozenset[int], bool]]] = {}
        """Point -> of what it accesses, the last steps of each thread, who writes it, and whether the point does."""
        for points, writing in shared:
            last: dict[int, list[int]] = {}
            for point in points:
                data.setdefault(point, []).append((last, writing, point in writing))
        for index, (point, thread, time_us) in enumerate(steps):
            if point not in data:
                continue
            earlier: set[int] = set()
            for last, writing, is_written in data[point]:
                for other, indices in last.items():
                    if other != thread:
                        for before in indices:
                            if is_written or steps[before][0] in writing:
                                earlier.add(before)
                own = last.get(thread)
                if own is None or steps[own[-1]][2] != time_us:
                    last[thread] = [index]
                else:
                    last[thread] = [before for before in own if steps[before][0] != point] + [index]
            for before in sorted(earlier):
                yield before, index

    def _common_data(self) -> set[tuple[frozenset[int], frozenset[int]]]:
        """Of data that several threads access and one writes: the points that do, and those that write it."""
        threads: dict[str, set[int]] = {}
        points: dict[str, set[int]] = {}
        writing: dict[str, set[int]] = {}
        for point, thread in {step[:2] for step in self.steps}:
            access = self.accesses[self.places[point]]
            for name in access.reads | access.writes:
                threads.setdefault(name, set()).add(thread)
                points.setdefault(name, set()).add(point)
            for name in access.writes:
                writing.setdefault(name, set()).add(point)
        return {(frozenset(points[name]), frozenset(writing[name])) for name in writing if len(threads[name]) > 1}

    def _conflict(self, gap_us: int, first: int, second: int) -> DataConflict:
        (point, thread, time_us), other = self.steps[first], self.steps[second]
        own = self._of_threads[thread]
        place = bisect_left(own, first)
        is_in_one_node = self.nodes[thread] == self.nodes[other[1]]
        return DataConflict(
            first=self.places[point],
            number=self._numbers[first],
            second=self.places[other[0]],
            step=first,
            time_s=time_us / US_PER_S,
            gap_s=gap_us / US_PER_S,
            previous=self._execution(own[place - 1]) if place else None,
            next=self._execution(own[place + 1]) if place + 1 < len(own) else None,
            is_in_one_node=is_in_one_node,
            awaited=self._wake_up(first) if is_in_one_node else None,
        )

    def _execution(self, index: int) -> tuple[str, int]:
        return self.places[self.steps[index][0]], self._numbers[index]

    def _wake_up(self, first: int) -> tuple[str, int] | None:
        """What another node executes before a task continues; None where it is not the next one to execute anything."""
        thread = self.steps[first][1]
        for index in range(first + 1, len(self.steps)):
            other = self.steps[index][1]
            if self.nodes[other] != self.nodes[thread]:
                return self._execution(index)
            if other != thread:
                return None
        return None
