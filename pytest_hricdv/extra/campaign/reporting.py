"""The report of a campaign: that of a session, with the sums over all runs."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from msgspec import structs

from pytest_hricdv._base.contained import files_inside
from pytest_hricdv._base.project_files import differences
from pytest_hricdv.extra.campaign.database import damage_error, error_location
from pytest_hricdv.extra.campaign.plan import CampaignPlan, RunKey
from pytest_hricdv.extra.campaign.records import CampaignResult, DifferingRun, LostRun
from pytest_hricdv.extra.campaign.statistics import Statistics
from pytest_hricdv.extra.campaign.store import Store
from pytest_hricdv.registry import offers
from pytest_hricdv.report import files
from pytest_hricdv.results.consistency import check_report
from pytest_hricdv.results.model import Report, TestResult
from pytest_hricdv.results.replay import Replay, ReplayError
from pytest_hricdv.results.report_builder import assemble
from pytest_hricdv.session.replaying import FOLDER


def campaign_report(store: Store, plan: CampaignPlan, most: int, output: Path) -> tuple[Report, str]:
    """The report, and what is wrong with it: see `assemble`.

    Args:
        most: largest number of runs that are all listed; of more, those to keep are.
        output: the folder of the report, into which the replay files of listed runs are written.

    Raises:
        CampaignError: the store is damaged.
        OSError: the folder cannot be written.
    """
    statistics = Statistics(sorted(plan.initial_report.requirements))
    keys = []
    with error_location(store.path):
        for row in store.rows():
            statistics.add(row)
            keys.append(row.key)
    listed = keys if len(keys) <= most else statistics.runs_to_keep()
    results = tuple(_results(store, plan, listed, output))
    counts = store.counts()
    with error_location(store.path):
        check_report(structs.replace(plan.initial_report, tests=results))
        report, problem = assemble(plan.initial_report, results, {}, counts.wall_s)
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
        differing=tuple(_differences(store, plan)),
    )
    report = structs.replace(report, campaign=campaign)
    for associate in offers("merging", "associate"):
        report = associate(report, is_of_all_runs=campaign.is_listed and not campaign.lost)
    return report, problem


def _results(store: Store, plan: CampaignPlan, keys: list[RunKey], output: Path) -> Iterator[TestResult]:
    """Results of runs; what failed gets its replay file."""
    with contextlib.suppress(OSError):
        for path in files_inside(output, FOLDER, (".json",)):  # of an earlier report
            path.unlink()
    for key, result, replay in store.results(keys):
        if result.id != plan.name(key):
            raise damage_error(store.path, f"the run of {plan.name(key)} has the result of {result.id}")
        if not replay:
            yield result
            continue
        path = files.write_inside(output, f"{FOLDER}/{result.id}.json", _check_replay(store, result, replay))
        yield structs.replace(result, replay=os.path.relpath(path))


def _check_replay(store: Store, result: TestResult, replay: str) -> str:
    """The text of a replay file, which is one, and of this run."""
    with error_location(store.path):
        try:
            if Replay.from_json(replay, f"replay of {result.id}").test.id == result.id:
                return replay
        except ReplayError as error:
            raise damage_error(store.path, error) from None
        raise ValueError(f"the replay of {result.id} is of another test")


def _differences(store: Store, plan: CampaignPlan) -> Iterator[DifferingRun]:
    repeats, workers = store.repeats(), store.workers()
    hashes = store.hashes(repeat.key for repeat in repeats)
    for repeat in repeats:
        if repeat.sha256 != hashes[repeat.key]:
            first, other = workers.get(store.row(repeat.key).worker), workers.get(repeat.worker)
            versions = differences(first.versions, other.versions) if first and other else ""
            yield DifferingRun(id=plan.name(repeat.key), parting=repeat.parting, versions=versions)
