"""Pairs: statements of different threads on the same data, in the order in which a run executes them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from pytest_hricdv._base.record import Count, NotNegative, PlainRecord
from pytest_hricdv.extra.schedules.points import DataAccess
from pytest_hricdv.extra.schedules.scheduler import PointStep

MOST_OF_A_PAIR = 8
"""So many executions of a pair are kept: the first, and then fewer and fewer."""


class DataConflict(PlainRecord, frozen=True, kw_only=True):
    """Two executions by different threads with the same data, one right after the other as far as the data goes.

    Args:
        first: place of the statement that came first.
        number: which execution of it this was, from 1.
        second: place of the other one.
        time_s: when the first one came (s of simulated time).
        gap_s: how much later the second one came (s).
        is_in_one_node: both are tasks of one loop: neither goes on while the other one is held up.
    """

    first: str
    number: Count
    second: str
    time_s: NotNegative
    gap_s: NotNegative
    is_in_one_node: bool = False

    @property
    def pair(self) -> tuple[str, str]:
        """Both places, in this order."""
        return self.first, self.second


def conflicts(
    steps: Sequence[PointStep], places: Sequence[str], accesses: Mapping[str, DataAccess]
) -> Iterator[DataConflict]:
    """Of what a run executed, in this order.

    Args:
        steps: what it executed.
        places: of points, by their numbers.
        accesses: place -> what its statement reads and writes.
    """
    last: dict[str, list[PointStep]] = {}
    for step in steps:
        place = places[step.point]
        access = accesses[place]
        found: dict[tuple[str, int], PointStep] = {}
        for name in access.reads | access.writes:
            for before in last.get(name, ()):
                other = accesses[places[before.point]]
                if before.thread != step.thread and (name in access.writes or name in other.writes):
                    found[places[before.point], before.number] = before
            last[name] = [*(entry for entry in last.get(name, ()) if entry.thread != step.thread), step]
        for before in found.values():
            yield DataConflict(
                first=places[before.point],
                number=before.number,
                second=place,
                time_s=round(before.time_s, 6),
                gap_s=round(step.time_s - before.time_s, 6),
                is_in_one_node=before.node == step.node,
            )


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
