"""The results of a campaign as text and chart; the same shards give the same bytes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from benchmarks.campaign import totals
from benchmarks.campaign.shard import Shard
from studies.page import interval, percent, table, thousands
from studies.plots import curves, figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_LISTED = 20


def text(shards: Sequence[Shard], known: Sequence[str] = ()) -> str:
    """Tables of verdicts, coverage and turns.

    Args:
        shards: in order; none of another campaign.
        known: requirements that are known to fail, whose failures are not listed.
    """
    parts = [verdicts(shards), spread(shards), covered(shards), turns(shards), listed(shards, known)]
    return "\n\n".join(part for part in parts if part) + "\n"


def verdicts(shards: Sequence[Shard]) -> str:
    """How often each requirement passed and failed."""
    rows = [
        [
            each.name,
            thousands(each.passed),
            thousands(each.failed),
            thousands(each.nc),
            thousands(each.triggers),
            f"{interval(each.rate, digits=2)} %" if each.rate else "-",
            f"{each.least[0]:.4g} in `{each.least[1]}`" if each.least else "-",
        ]
        for each in totals.requirements(shards)
    ]
    head = ["", "Passed", "Failed", "NC", "checks", "failed, of the runs that checked it", "least margin"]
    return table(head, rows)


def spread(shards: Sequence[Shard]) -> str:
    """Spread between seeds."""
    rows = [
        [each.name, f"{each.by_seed[0]} to {each.by_seed[1]}", each.ever, each.always, each.unsettled]
        for each in totals.requirements(shards)
    ]
    head = [
        "",
        "failing runs of a seed",
        "abstract tests that failed with some seed",
        "with every seed",
        "whose verdict depends on the seed",
    ]
    return table(head, rows)


def covered(shards: Sequence[Shard]) -> str:
    """Coverage of the code under test."""
    found, (first, all_of) = totals.coverage(shards), totals.bins(shards)
    low, high = (percent(each, 2) for each in found.seed_statements)
    rows = [
        ("statements per run, mean", f"{interval(found.per_run, 1, 2)} %"),
        ("statements per run, highest", percent(found.most, 2)),
        ("statements by all runs of one seed, of the reachable", f"{low} to {high}"),
        ("statements by all runs, of the reachable", percent(found.statements, 2)),
        ("branches by all runs, of the reachable", percent(found.branches, 2)),
        ("bins of the cross products, first seed and all seeds", f"{first} and {all_of}"),
        ("reachable statements that no run reached", "; ".join(found.missing) or "none"),
    ]
    return table(["code under test", ""], rows)


def turns(shards: Sequence[Shard]) -> str:
    """How turns ended."""
    rows = [
        [name, thousands(number), f"{interval(rate, digits=2)} %"] for name, number, rate in totals.outcomes(shards)
    ]
    return table(["turns", "", "share"], rows)


def listed(shards: Sequence[Shard], known: Sequence[str]) -> str:
    """Runs that ended with an error, and runs that violated a requirement that is not known to fail."""
    found = [f"- `{run.id}` did not end: {run.error}" for shard in shards for run in shard.runs if run.error]
    for run in totals.ended(shards):
        failed = [name for name, verdict in run.verdicts.items() if verdict == "Failed" and name not in known]
        if failed:
            found.append(f"- {' and '.join(failed)} in `{run.id}`")
    if not found:
        return ""
    shown = sorted(found)[:MOST_LISTED]
    more = [f"- and {len(found) - len(shown)} more"] if len(found) > len(shown) else []
    return "\n".join(["Failures of what is not known to fail:", "", *shown, *more])


def picture(shards: Sequence[Shard], requirement: str) -> Figure:
    """Growth with the number of seeds: coverage, and tests that fail a requirement."""
    made, (left, right) = figure(panels=2)
    lines = {"statements": totals.growth(shards, totals.statements, shards[0].statements.reachable)}
    if shards[0].branches is not None:
        lines["branches"] = totals.growth(shards, totals.branches, shards[0].branches.reachable)
    axis = "seeds (number)"
    curves(left, lines, x=axis, y="covered by all runs so far (% of the reachable)", drawn="steps-post")
    left.set_ylim(0, 100)
    left.legend(loc="lower right")
    failed = {requirement: totals.failing(shards, requirement)}
    curves(right, failed, x=axis, y=f"abstract tests that failed {requirement} so far (number)", drawn="steps-post")
    right.set_ylim(bottom=0)
    return made
