"""The report of a campaign: that of a session, with the sums over all runs."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from msgspec import structs

from pytest_hricdv._base.atomic_file import write_text
from pytest_hricdv._base.project_files import differences
from pytest_hricdv.extra.campaign.plan import CampaignPlan, RunKey
from pytest_hricdv.extra.campaign.records import CampaignResult, DifferingRun, LostRun
from pytest_hricdv.extra.campaign.statistics import Statistics
from pytest_hricdv.extra.campaign.store import Store
from pytest_hricdv.results.assembling import assemble
from pytest_hricdv.results.model import Report, TestResult
from pytest_hricdv.session.replaying import FOLDER


def campaign_report(store: Store, plan: CampaignPlan, most: int, output: Path) -> tuple[Report, str]:
    """The report, and what is wrong with it: see `assemble`.

    Args:
        most: lists all runs where they are at most so many, and those to keep otherwise.
        output: the folder of the report, into which the replay files of listed runs are written.

    Raises:
        CampaignError: the store is damaged.
        OSError: the folder cannot be written.
    """
    statistics = Statistics(sorted(plan.declared.requirements))
    keys = []
    for row in store.rows():
        statistics.add(row)
        keys.append(row.key)
    listed = keys if len(keys) <= most else statistics.kept()
    results = tuple(_results(store, listed, output / FOLDER))
    counts = store.counts()
    report, problem = assemble(plan.declared, results, {}, counts.wall_s)
    campaign = CampaignResult(
        expected=plan.runs,
        stored=len(keys),
        concretizations=plan.concretizations,
        sim_s=round(counts.sim_s, 3),
        is_listed=len(listed) == len(keys),
        outcomes=dict(sorted(statistics.outcomes.items())),
        endings=dict(sorted(statistics.endings.items())),
        requirements=statistics.of_requirements(plan),
        tests=tuple(statistics.of_tests(plan)),
        lost=tuple(LostRun(id=plan.name(key), reason=reason) for key, reason in statistics.lost),
        repeated=counts.repeated,
        differing=tuple(_differing(store, plan)),
    )
    return structs.replace(report, campaign=campaign), problem


def _results(store: Store, keys: list[RunKey], folder: Path) -> Iterator[TestResult]:
    """Results of runs; what failed gets its replay file."""
    with contextlib.suppress(OSError):
        for path in folder.glob("*.json"):  # of an earlier report
            path.unlink()
    for _, result, replay in store.results(keys):
        if not replay:
            yield result
            continue
        path = write_text(folder / f"{result.id}.json", replay)
        yield structs.replace(result, replay=os.path.relpath(path))


def _differing(store: Store, plan: CampaignPlan) -> Iterator[DifferingRun]:
    repeats, workers = store.repeats(), store.workers()
    hashes = store.hashes(repeat.key for repeat in repeats)
    for repeat in repeats:
        if repeat.sha256 != hashes[repeat.key]:
            first, other = workers[store.row(repeat.key).worker], workers[repeat.worker]
            versions = differences(first.versions, other.versions)
            yield DifferingRun(id=plan.name(repeat.key), parting=repeat.parting, versions=versions)
