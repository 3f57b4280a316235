"""Statistics over all seeds of a campaign: totals, spread, and growth with the number of seeds."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from statistics import fmean

from benchmarks.campaign.shard import CampaignRun, Shard
from studies.estimates import Interval, mean, share


@dataclass(frozen=True)
class Requirement:
    """One requirement over all runs.

    Args:
        passed: runs, as `failed` and `nc` (not checked).
        triggers: checks in all runs.
        rate: failed, of the runs that checked it.
        by_seed: fewest and most failing runs of a seed.
        ever: abstract tests that failed with at least one seed.
        always: abstract tests that failed with every seed.
        unsettled: abstract tests whose verdict depends on the seed.
        least: the run with the least margin, and that margin.
    """

    name: str
    title: str
    passed: int
    failed: int
    nc: int
    triggers: int
    rate: Interval | None
    by_seed: tuple[int, int]
    ever: int
    always: int
    unsettled: int
    least: tuple[float, str] | None


def ended(shards: Iterable[Shard]) -> list[CampaignRun]:
    """All runs that ended without an error, seed by seed."""
    return [run for shard in shards for run in shard.runs if not run.error]


def requirements(shards: Sequence[Shard]) -> list[Requirement]:
    """Each requirement, in order."""
    titles = shards[0].titles
    return [_requirement(name, titles[name], shards) for name in sorted(titles)]


def _requirement(name: str, title: str, shards: Sequence[Shard]) -> Requirement:
    runs = ended(shards)
    counts = Counter(run.verdicts[name] for run in runs)
    verdicts: dict[str, set[str]] = {}
    for run in runs:
        verdicts.setdefault(run.test, set()).add(run.verdicts[name])
    failed = [sum(run.verdicts[name] == "Failed" for run in ended([shard])) for shard in shards]
    margins = [(margin, run.id) for run in runs if (margin := run.margins[name]) is not None]
    return Requirement(
        name=name,
        title=title,
        passed=counts["Passed"],
        failed=counts["Failed"],
        nc=counts["NC"],
        triggers=sum(run.triggers[name] for run in runs),
        rate=share(counts["Failed"], counts["Passed"] + counts["Failed"]),
        by_seed=(min(failed), max(failed)),
        ever=sum("Failed" in each for each in verdicts.values()),
        always=sum(each == {"Failed"} for each in verdicts.values()),
        unsettled=sum(len(each) > 1 for each in verdicts.values()),
        least=min(margins) if margins else None,
    )


@dataclass(frozen=True)
class Coverage:
    """Statements of the code under test, in % of all; and what all runs together reach, in % of the reachable.

    Args:
        per_run: mean of the seeds' means, with the interval over seeds.
        most: the highest of a run.
        statements: that all runs reach together; likewise branches, None where they are not measured.
        seed_statements: the least and the most that the runs of one seed reach together.
        missing: statements that no run reached and that are not waived, as `file: lines`.
    """

    per_run: Interval
    most: float
    statements: float
    branches: float | None
    seed_statements: tuple[float, float]
    missing: tuple[str, ...]


def coverage(shards: Sequence[Shard]) -> Coverage:
    """Coverage of all runs."""
    count, reachable = shards[0].statements.count, shards[0].statements.reachable
    percents = [[100.0 * run.statements.bit_count() / count for run in ended([shard])] for shard in shards]
    reached = [100.0 * union(ended([shard]), statements).bit_count() / reachable for shard in shards]
    return Coverage(
        per_run=mean([fmean(each) for each in percents if each]),
        most=max(max(each) for each in percents if each),
        statements=100.0 * union(ended(shards), statements).bit_count() / reachable,
        branches=_branches(shards),
        seed_statements=(min(reached), max(reached)),
        missing=_missing(shards),
    )


def statements(run: CampaignRun) -> int:
    """The statements that a run covered, as a bit set."""
    return run.statements


def branches(run: CampaignRun) -> int:
    """The branches that a run covered, as a bit set; empty where they are not measured."""
    return run.branches or 0


def union(runs: Iterable[CampaignRun], of: Callable[[CampaignRun], int]) -> int:
    """The bits of all runs together."""
    bits = 0
    for run in runs:
        bits |= of(run)
    return bits


def _branches(shards: Sequence[Shard]) -> float | None:
    total = shards[0].branches
    return 100.0 * union(ended(shards), branches).bit_count() / total.reachable if total else None


def _missing(shards: Sequence[Shard]) -> tuple[str, ...]:
    found = []
    for file in sorted(shards[0].missing):
        lines = set.intersection(*(set(shard.missing.get(file, ())) for shard in shards))
        left = sorted(lines - set(shards[0].waived.get(file, ())))
        if left:
            found.append(f"{file}: {', '.join(map(str, left))}")
    return tuple(found)


def growth(shards: Sequence[Shard], of: Callable[[CampaignRun], int], whole: int) -> list[tuple[float, float]]:
    """Covered after 1, 2, ... seeds, % of the whole."""
    bits, points = 0, []
    for number, shard in enumerate(shards, 1):
        bits |= union(ended([shard]), of)
        points.append((float(number), 100.0 * bits.bit_count() / whole))
    return points


def failing(shards: Sequence[Shard], requirement: str) -> list[tuple[float, float]]:
    """Abstract tests that have failed a requirement at least once after 1, 2, ... seeds."""
    seen: set[str] = set()
    points = []
    for number, shard in enumerate(shards, 1):
        seen |= {run.test for run in ended([shard]) if run.verdicts[requirement] == "Failed"}
        points.append((float(number), float(len(seen))))
    return points


def outcomes(shards: Sequence[Shard]) -> list[tuple[str, int, Interval | None]]:
    """How turns ended: how many, and which share of all."""
    counts = Counter(leg for run in ended(shards) for leg in run.legs)
    total = sum(counts.values())
    return [(name, number, share(number, total)) for name, number in sorted(counts.items())]


def bins(shards: Sequence[Shard]) -> tuple[int, int]:
    """Bins of the cross products that the first seed hit, and that all did."""
    first = {each for run in ended(shards[:1]) for each in run.bins}
    return len(first), len({each for run in ended(shards) for each in run.bins})
