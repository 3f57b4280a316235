"""How near the runs of a loop came to violations, and how many kinds of violations a further run would find.

The estimate is that of Good and Turing, over kinds of violations in place of points; see `GoodTuring` in `records`.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Container, Iterator

from pytest_hricdv.extra.closing.archive import Archive
from pytest_hricdv.extra.closing.records import NearestRun, ViolationEstimate
from pytest_hricdv.extra.closing.violation_way import NAME, never_decisive
from pytest_hricdv.extra.closing.violations import FAULT, NEW


def nearest_runs(archive: Archive, handed: Container[int], without: Container[int]) -> Iterator[NearestRun]:
    """Of each requirement that a run triggered, the run with the least margin.

    Args:
        archive: all runs.
        handed: numbers of runs whose tests are handed over: of equal margins, theirs come first.
        without: numbers of runs that do not repeat.
    """
    runs = [entry for entry in archive.entries if entry.number not in without]
    tried = Counter(target[1] for entry in runs if entry.way == NAME for target in entry.targets)
    for name in sorted({name for entry in runs for name in entry.observation.unused}):
        triggered = [entry for entry in runs if name in entry.observation.unused]
        margins = {entry.number: entry.observation.margins.get(name, math.inf) for entry in triggered}
        nearest = min(triggered, key=lambda entry: (margins[entry.number], entry.number not in handed, entry.number))
        finite = [margin for margin in margins.values() if margin < math.inf]
        yield NearestRun(
            requirement=name,
            margin=min(finite, default=None),
            spread=round(max(finite) - min(finite), 9) if finite else None,
            test=nearest.test.id if finite else "",
            runs=len(triggered),
            searched=tried[name],
            never_decisive=never_decisive(archive, name),
        )


def violation_estimate(archive: Archive, without: Container[int]) -> ViolationEstimate | None:
    """How many kinds of violations that are not known a further run would show; None without runs."""
    runs = [entry for entry in archive.entries if entry.number not in without and not entry.observation.error]
    if not runs:
        return None
    times = Counter(point for entry in runs for point in entry.observation.points if point[0] in (NEW, FAULT))
    once = sum(count == 1 for count in times.values())
    return ViolationEstimate(kinds=len(times), once=once, runs=len(runs), new=once / len(runs))
