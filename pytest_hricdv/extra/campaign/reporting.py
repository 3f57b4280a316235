"""`campaign_report` makes the report of a campaign: sums over all runs, and as tests all runs or those worth keeping.

The command `report` and `hricdv report live` call it. `Statistics` sums up rows one by one, to save memory.
"""

from __future__ import annotations

import contextlib
import os
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from msgspec import structs

from pytest_hricdv._base.contained import files_inside
from pytest_hricdv._base.project_files import differences
from pytest_hricdv.extra.campaign.database import LOST, Row, RowSummary, damage_error, error_location
from pytest_hricdv.extra.campaign.plan import CampaignPlan, RunKey
from pytest_hricdv.extra.campaign.records import (
    CampaignRequirement,
    CampaignResult,
    CampaignTest,
    DifferingRun,
    FailedShare,
    LeastMargin,
    LostRun,
)
from pytest_hricdv.extra.campaign.store import Store
from pytest_hricdv.registry import offers
from pytest_hricdv.report import files
from pytest_hricdv.results.codec import check_report
from pytest_hricdv.results.model import Report, TestResult
from pytest_hricdv.results.proportion import share
from pytest_hricdv.results.replay import Replay, ReplayError
from pytest_hricdv.results.report_builder import assemble
from pytest_hricdv.session.replaying import FOLDER

FAILED, PASSED, NC = "Failed", "Passed", "NC"


@dataclass
class _TestSums:
    """The sums of one abstract test."""

    outcomes: Counter[str] = field(default_factory=Counter)
    verdicts: dict[str, Counter[str]] = field(default_factory=dict)
    least: dict[str, tuple[float, RunKey]] = field(default_factory=dict)
    keep: list[RunKey] = field(default_factory=list)


class Statistics:
    """Accumulates the sums of rows, which must come sorted by test and concretization.

    Args:
        requirements: the requirements, in the order of the rows' verdicts.
    """

    def __init__(self, requirements: Iterable[str]) -> None:
        self.requirements = tuple(requirements)
        self.outcomes: Counter[str] = Counter()
        self.endings: Counter[str] = Counter()
        self.triggers: Counter[str] = Counter()
        self.lost: list[tuple[RunKey, str]] = []
        self._tests: dict[int, _TestSums] = {}
        self._statements = self._branches = 0
        self._seen: set[object] = set()

    def add(self, row: Row) -> None:
        """Take in a run."""
        test = self._tests.setdefault(row.key[0], _TestSums())
        self.outcomes[row.outcome] += 1
        test.outcomes[row.outcome] += 1
        self.endings.update(row.summary.endings)
        if row.outcome == LOST:
            self.lost.append((row.key, row.summary.note))
            return
        verdicts = [judgement[0] for judgement in row.summary.judgements]
        judged = dict(zip(self.requirements, verdicts, strict=True))
        # Not `or`: the first call also records the run.
        if self._adds_coverage(row.summary, judged) | self._adds_violation(test, row, judged):
            test.keep.append(row.key)
        for name, (verdict, triggers, margin) in zip(self.requirements, row.summary.judgements, strict=True):
            test.verdicts.setdefault(name, Counter())[verdict] += 1
            self.triggers[name] += triggers
            if margin is not None and (name not in test.least or margin < test.least[name][0]):
                test.least[name] = margin, row.key

    def _adds_coverage(self, summary: RowSummary, verdicts: Mapping[str, str]) -> bool:
        """Whether it hits what no run before did: code, bins, verdicts."""
        points = {(name, *hit) for name, hits in summary.bins.items() for hit in hits}
        points |= {judged for judged in verdicts.items() if judged[1] != NC}
        statements, branches = int(summary.statements, 16), int(summary.branches, 16)
        adds = bool(statements & ~self._statements or branches & ~self._branches or points - self._seen)
        self._statements |= statements
        self._branches |= branches
        self._seen |= points
        return adds

    def _adds_violation(self, test: _TestSums, row: Row, verdicts: Mapping[str, str]) -> bool:
        """Whether it is the first run of its test to violate a requirement, or to end as it did."""
        failed = {name for name, verdict in verdicts.items() if verdict == FAILED}
        before = {name for name, counts in test.verdicts.items() if counts[FAILED]}
        return bool(failed - before) or (row.outcome != "passed" and test.outcomes[row.outcome] == 1)

    def least(self, name: str) -> tuple[float, RunKey] | None:
        """The least margin of a requirement, and the first run that has it."""
        return min((test.least[name] for test in self._tests.values() if name in test.least), default=None)

    def runs_to_keep(self) -> list[RunKey]:
        """The runs that are worth keeping: see `CampaignTest`."""
        tightest = [least[1] for name in self.requirements if (least := self.least(name)) is not None]
        return sorted({*tightest, *(key for test in self._tests.values() for key in test.keep)})

    def of_requirements(self, plan: CampaignPlan) -> dict[str, CampaignRequirement]:
        """Each requirement over all runs."""
        return {name: self._sum_requirement(name, plan) for name in self.requirements}

    def _sum_requirement(self, name: str, plan: CampaignPlan) -> CampaignRequirement:
        verdicts = [test.verdicts[name] for test in self._tests.values() if name in test.verdicts]
        counts: Counter[str] = sum(verdicts, Counter())
        least = self.least(name)
        return CampaignRequirement(
            passed=counts[PASSED],
            failed=counts[FAILED],
            nc=counts[NC],
            triggers=self.triggers[name],
            share=failure_share(counts),
            ever=sum(by_verdict[FAILED] > 0 for by_verdict in verdicts),
            always=sum(0 < by_verdict[FAILED] == by_verdict.total() for by_verdict in verdicts),
            # A unary plus leaves the counts of 0 out.
            unsettled=sum(len(+by_verdict) > 1 for by_verdict in verdicts),
            least=None if least is None else LeastMargin(margin=least[0], run=plan.name(least[1])),
        )

    def of_tests(self, plan: CampaignPlan) -> Iterator[CampaignTest]:
        """Each abstract test over all of its seeds."""
        kept = {key: plan.name(key) for key in self.runs_to_keep()}
        by_test: dict[int, list[str]] = {}
        for key, name in kept.items():
            by_test.setdefault(key[0], []).append(name)
        for number, test in sorted(self._tests.items()):
            yield CampaignTest(
                id=plan.tests[number].id,
                suite=plan.planned.tests[number].suite,
                runs=test.outcomes.total(),
                outcomes=dict(sorted(test.outcomes.items())),
                failed={name: failure_share(counts) for name, counts in test.verdicts.items() if counts[FAILED]},
                least=_margins(test.least, plan),
                keep=tuple(by_test.get(number, ())),
            )


def _margins(least: Mapping[str, tuple[float, RunKey]], plan: CampaignPlan) -> dict[str, LeastMargin]:
    return {name: LeastMargin(margin=margin, run=plan.name(key)) for name, (margin, key) in least.items()}


def failure_share(counts: Mapping[str, int]) -> FailedShare:
    """The share of the runs that violated a requirement, of verdict -> runs."""
    failed, checked = counts.get(FAILED, 0), counts.get(FAILED, 0) + counts.get(PASSED, 0)
    interval = share(failed, checked)
    low, high = (interval.low, interval.high) if interval else (0.0, 1.0)
    return FailedShare(failed=failed, checked=checked, low=round(100 * low, 4), high=round(100 * high, 4))


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
