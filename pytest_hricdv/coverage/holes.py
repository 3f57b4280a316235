"""Holes of a cross product: bins that no test hit, in groups that one sentence describes.

A list of a hundred bins says little; "whatever the rest, never released with none ready" says what to generate.
Method: hole analysis by projection (Lachish, Marcus, Ur, Ziv: Hole analysis for functional coverage data, DAC 2002).
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

MAX_PROJECTIONS = 200_000
"""Bins times subsets of coordinates to search for holes: 3 s. In a larger product each open bin is its own hole."""

Bin = tuple[str, ...]
Projection = tuple[tuple[int, str], ...]
"""Values of some coordinates: place of the coordinate and value."""


@dataclass(frozen=True)
class Hole:
    """All bins with these values of some coordinates, none of which was hit.

    Args:
        values: coordinate and value; all coordinates where it is a single bin.
        bins: number of its bins that no larger hole has, and that closing it adds.
    """

    values: tuple[tuple[str, str], ...]
    bins: int


def holes(coordinates: Sequence[str], open_bins: Collection[Bin], missing: Collection[Bin]) -> tuple[Hole, ...]:
    """The holes that have all missing bins, the largest first.

    Args:
        coordinates: of the product, by name.
        open_bins: that are to be hit: possible and legal.
        missing: those of them that no test hit.
    """
    left = dict.fromkeys(missing)
    if len(open_bins) << len(coordinates) > MAX_PROJECTIONS:
        return tuple(Hole(tuple(zip(coordinates, bin_, strict=True)), 1) for bin_ in left)
    size = Counter(values for bin_ in open_bins for values in _projections(bin_))
    members: dict[Projection, list[Bin]] = {}
    for bin_ in left:
        for values in _projections(bin_):
            members.setdefault(values, []).append(bin_)
    count = {values: len(bins) for values, bins in members.items()}
    whole = sorted(
        (values for values in members if count[values] == size[values]), key=lambda values: (len(values), values)
    )
    # The largest first; of equal ones the one with fewest values. A count only falls, so a lazy heap re-evaluates few.
    queue = [(-count[values], place) for place, values in enumerate(whole)]
    heapq.heapify(queue)
    chosen = []
    while left:
        negative, place = heapq.heappop(queue)
        best = whole[place]
        if count[best] < -negative:
            heapq.heappush(queue, (-count[best], place))
            continue
        chosen.append(Hole(tuple((coordinates[number], value) for number, value in best), count[best]))
        for bin_ in members[best]:
            if bin_ in left:
                del left[bin_]
                for values in _projections(bin_):
                    count[values] -= 1
    return tuple(chosen)


def _projections(bin_: Bin) -> Iterator[Projection]:
    """Its values of each subset of coordinates, also of none: that is the hole of a product without any hit."""
    valued = tuple(enumerate(bin_))
    for number in range(len(bin_) + 1):
        yield from combinations(valued, number)
