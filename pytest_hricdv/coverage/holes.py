"""Holes of a cross product: bins that no test hit, in groups that one sentence describes.

A list of a hundred bins says little; "whatever the rest, never released with none ready" says what to generate.
Method: hole analysis by projection (Lachish, Marcus, Ur, Ziv: Hole analysis for functional coverage data, DAC 2002).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

MOST_PROJECTIONS = 200_000
"""Bins times subsets of coordinates that are looked at; of a larger product each bin is a hole of its own."""

Bin = tuple[str, ...]
Projection = tuple[tuple[int, str], ...]
"""Values of some coordinates: place of the coordinate and value."""


@dataclass(frozen=True)
class Hole:
    """All bins with these values of some coordinates, none of which was hit.

    Args:
        values: coordinate and value; all coordinates where it is a single bin.
        bins: how many bins of it no larger hole has: so many are closed with it.
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
    if len(open_bins) << len(coordinates) > MOST_PROJECTIONS:
        return tuple(Hole(tuple(zip(coordinates, each, strict=True)), 1) for each in left)
    size, empty = Counter[Projection](), Counter[Projection]()
    for each in open_bins:
        size.update(_projections(each))
    for each in left:
        empty.update(_projections(each))
    whole = sorted((each for each in empty if empty[each] == size[each]), key=lambda each: (len(each), each))
    found = []
    while left:
        counts = Counter(projection for each in left for projection in _projections(each))
        best = max(whole, key=lambda projection: counts[projection])  # of equal ones the first has fewest values
        found.append(Hole(tuple((coordinates[place], value) for place, value in best), counts[best]))
        left = {each: None for each in left if any(each[place] != value for place, value in best)}
    return tuple(found)


def _projections(found: Bin) -> Iterator[Projection]:
    """Its values of each subset of coordinates, also of none: that is the hole of a product without any hit."""
    valued = tuple(enumerate(found))
    for number in range(len(found) + 1):
        yield from combinations(valued, number)
