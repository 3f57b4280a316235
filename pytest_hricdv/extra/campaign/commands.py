"""The commands of `hricdv campaign`: `run`, `status`, `cancel`, `report`, `export`.

The parser in `__main__` calls them with the options. Exit status: 0 if all is well; 1 if runs failed or were lost, a
repeated run differs, or a gate fails; 2 if the campaign cannot be run or read; 3 if it ended before all was done.
Progress is one line that is rewritten on a terminal, and ten lines elsewhere.
"""

from __future__ import annotations

import argparse
import datetime
import shlex
import shutil
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import closing
from pathlib import Path
from typing import TextIO

from msgspec import structs

from pytest_hricdv._base.message import harmless_line, list_names, visible
from pytest_hricdv._base.project_files import differences
from pytest_hricdv.execution.outcome import FAILING
from pytest_hricdv.extra.campaign.database import LOST
from pytest_hricdv.extra.campaign.execution import CancelledError, Execution, audit
from pytest_hricdv.extra.campaign.plan import FOLLOWS_TESTS, CampaignError, CampaignPlan, make_plan
from pytest_hricdv.extra.campaign.records import CAMPAIGN
from pytest_hricdv.extra.campaign.reporting import campaign_report
from pytest_hricdv.extra.campaign.store import Counts, Store
from pytest_hricdv.extra.campaign.table import write_parquet
from pytest_hricdv.report import files, terminal
from pytest_hricdv.report.failing_tests import FailingTests
from pytest_hricdv.report.formatting import fit_list
from pytest_hricdv.results.gate_check import check_gates, gates_of
from pytest_hricdv.results.model import GateResult, Report
from pytest_hricdv.session.progress import time_left
from pytest_hricdv.session.remote import ClusterError, Remote, RemoteProject, remote

OK, FAILED_RUNS, USAGE, UNFINISHED = 0, 1, 2, 3

MAX_LISTED = 7000
"""Maximum number of tests that the report lists: a page with more takes seconds to open."""

_SHOWN = 10  # maximum number of runs of a kind that the terminal lists
STEPS = 10  # number of progress lines in a log, as of CI, however long the campaign is
EVERY_S = 1.0  # minimum time (s) between updates of the progress: counting a million rows takes 0.13 s


def outcomes(counts: Mapping[str, int]) -> str:
    """`12 failed, 1 lost`."""
    failed, lost = sum(counts.get(name, 0) for name in FAILING), counts.get(LOST, 0)
    return f"{failed:,} failed, {lost:,} lost"


class CampaignProgress:
    """Shows the progress of a campaign.

    Args:
        expected: runs of the campaign.
    """

    def __init__(self, store: Store, expected: int, stream: TextIO = sys.stdout) -> None:
        self._store = store
        self._expected = expected
        self._stream = stream
        self._began_s = self._last_s = time.monotonic()
        self._before = store.counts()
        self._step = self._step_of(self._before.runs)
        self._rewrites = stream.isatty()
        self._has_line = False

    def show(self) -> None:
        """Tell it, where there is something new to tell."""
        now_s = time.monotonic()
        if now_s - self._last_s < EVERY_S:
            return
        self._last_s = now_s
        counts = self._store.counts()
        step = self._step_of(counts.runs)
        if self._rewrites:
            line = fit_list(self._texts(now_s), shutil.get_terminal_size().columns - 1)  # one that wraps leaves a rest
            self._stream.write(f"\r\x1b[2K{line}")
            self._has_line = True
        elif step > self._step:
            self._stream.write(f"{self._texts(now_s)[0]}\n")
        self._step = step
        self._stream.flush()

    def _texts(self, now_s: float) -> list[str]:
        """The fullest first: then without the speed, the time left, and the outcomes."""
        counts, took_s = self._store.counts(), max(1e-9, now_s - self._began_s)
        done = counts.runs - self._before.runs
        speed = (counts.sim_s - self._before.sim_s) / took_s
        left = (self._expected - counts.runs) * took_s / done if done else None
        start = [f"{counts.runs:,} of {self._expected:,} runs", outcomes(counts.outcomes)]
        end = [time_left(left)] if left is not None and counts.runs < self._expected else []
        fullest = [*start, f"{speed:,.0f} simulated s a second", *end]
        return [", ".join(parts) for parts in (fullest, [*start, *end], start, start[:1])]

    def say(self, text: str) -> None:
        """Tell something else, on a line of its own."""
        if self._has_line:
            self._stream.write("\r\x1b[2K")
            self._has_line = False
        self._stream.write(f"{visible(text)}\n")
        self._stream.flush()

    def _step_of(self, stored: int) -> int:
        return stored * STEPS // max(1, self._expected)


def run(options: argparse.Namespace) -> int:
    """Begin a campaign, or continue with it."""
    folder, state = Path.cwd(), options.state.resolve()
    plan = make_plan(_arguments(options), options.concretizations, folder)
    root = (folder / plan.planned.rootdir).resolve()
    project = cluster_of_campaign().project(
        root, folder.resolve(), send=options.send_code, state=state, hidden=options.send_hidden
    )
    with closing(_open_store(state, plan)) as store:
        if options.retry_lost:
            store.forget_lost()
        store.begin(datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"), plan)
        progress = CampaignProgress(store, plan.runs)
        progress.say(_headline(options, plan, store.counts()))
        for name in plan.planned.left_out:
            progress.say(f"left out: {name}: {FOLLOWS_TESTS}")
        why = _execute(options, plan, store, project, progress)
        return _tell_end(options.state, plan, store, progress, why)


def cluster_of_campaign() -> Remote:
    """The cluster that runs it. Raises CampaignError if there is none."""
    cluster = remote()
    if cluster is None:
        raise CampaignError("campaigns run on the feature 'cluster', which is not installed")
    return cluster


def _arguments(options: argparse.Namespace) -> tuple[str, ...]:
    """The arguments of pytest."""
    tests = [f"--hri-tests={options.tests}"] if options.tests else []
    return (f"--hri-suite={options.suite}", f"--hri-seed={options.seed}", *tests, *options.pytest)


def _open_store(path: Path, plan: CampaignPlan) -> Store:
    """The store, new or old, locked against other writers. Raises CampaignError if it is of another campaign."""
    if not path.exists():
        store = Store.create(path, plan)
        store.hold()
        return store
    store = Store.open(path)
    store.hold()
    differ = store.plan().difference(plan)
    if differ:
        stored = store.counts().runs
        store.close()
        raise CampaignError(
            f"{path}: its {stored:,} runs are of another campaign: {differ}. Runs of different code cannot share a "
            "report: restore that code to finish it, or give another --state"
        )
    return store


def _headline(options: argparse.Namespace, plan: CampaignPlan, counts: Counts) -> str:
    tests = f"{len(plan.planned.tests):,} abstract tests, {plan.concretizations} seeds of each"
    done = f"; {counts.runs:,} are done" if counts.runs else ""
    return f"campaign {options.state}: {tests}: {plan.runs:,} runs{done}; on {options.cluster}"


def _execute(
    options: argparse.Namespace, plan: CampaignPlan, store: Store, project: RemoteProject, progress: CampaignProgress
) -> str:
    """Run what is missing; returns why it ended before all was done."""
    began_s = time.monotonic()
    try:
        with cluster_of_campaign().connect(options.cluster, progress.say) as workers:
            if workers.dashboard:
                progress.say(f"dashboard of the cluster: {workers.dashboard}")
            execution = Execution(plan, store, workers, options.run_seconds, project, progress.show)
            execution.run()
            audit(execution, options.audit)
    except CancelledError:
        return "cancelled"
    except KeyboardInterrupt:
        return "interrupted"
    except ClusterError as error:
        return str(error)
    finally:
        store.record_duration(round(time.monotonic() - began_s, 3))
    return ""


def _tell_end(state: Path, plan: CampaignPlan, store: Store, progress: CampaignProgress, why: str) -> int:
    counts = store.counts()
    if why:
        progress.say(f"ended before all was done: {why}")
    for text in _summary(plan, store, counts):
        progress.say(text)
    if counts.runs < plan.runs or why:
        progress.say("the same command resumes it")
        return UNFINISHED
    progress.say(f"its report: hricdv campaign report --state={state}")
    failed = sum(counts.outcomes.get(name, 0) for name in (*FAILING, LOST))
    return FAILED_RUNS if failed or counts.differing else OK


def _summary(plan: CampaignPlan, store: Store, counts: Counts) -> Iterator[str]:
    """The progress of a campaign, and its problems."""
    yield f"expected {plan.runs:,}, stored {counts.runs:,}: {outcomes(counts.outcomes)}"
    if 0 < plan.runs - counts.runs <= _SHOWN:
        done = store.keys()
        yield f"missing: {', '.join(plan.name(key) for key in plan.run_keys() if key not in done)}"
    yield f"repeated {counts.repeated:,}, on another worker if there is one; {counts.differing:,} differ"
    lost = store.losses()
    for key, reason in lost[:_SHOWN]:
        yield f"lost: {plan.name(key)}: {reason}"
    if len(lost) > _SHOWN:
        yield f"lost: and {len(lost) - _SHOWN:,} more"
    hashes = store.hashes(repeat.key for repeat in store.repeats())
    for repeat in [repeat for repeat in store.repeats() if repeat.sha256 != hashes[repeat.key]][:_SHOWN]:
        yield f"differs: {plan.name(repeat.key)}: {repeat.parting}"


def status(options: argparse.Namespace) -> int:
    """The progress of a campaign, and the workers that took part."""
    with closing(Store.open(options.state.resolve())) as store:
        plan, counts = store.plan(), store.counts()
        command = visible(shlex.join(plan.planned.arguments))
        print(f"campaign {options.state}: pytest {command}, {plan.concretizations} seeds of a test")
        for text in _summary(plan, store, counts):
            print(harmless_line(text))
        speed = f", {counts.sim_s / counts.wall_s:,.0f} a second" if counts.wall_s else ""
        print(f"{counts.sim_s:,.0f} s simulated in {counts.wall_s:,.0f} s{speed}")
        done, workers = store.runs_of_workers(), store.workers()
        first = next(iter(workers.values()), None)
        for number, worker in workers.items():
            differ = differences(first.versions, worker.versions) if first else ""
            versions = f"; other versions: {differ}" if differ else ""
            print(harmless_line(f"worker {worker.address} on {worker.host}: {done.get(number, 0):,} runs{versions}"))
    return OK


def cancel(options: argparse.Namespace) -> int:
    """Let whoever runs the campaign end it in an orderly way."""
    with closing(Store.open(options.state.resolve())) as store:
        store.cancel()
    print(f"{options.state}: its process stops within seconds; stored results are kept")
    return OK


def report(options: argparse.Namespace) -> int:
    """Write the report of all runs, and check the gates of the project."""
    with closing(Store.open(options.state.resolve())) as store:
        plan = store.plan()
        if not store.counts().runs:
            raise CampaignError(f"{options.state}: no run is stored yet: there is nothing to report")
        made, problem = campaign_report(store, plan, options.most, options.output)
    checked = check_gates(
        made, gates_of(made, fail_on_nc=True), None, datetime.datetime.now(datetime.UTC).date(), whole=True
    )
    failed = [problem] if problem else []
    failed += [*_failures(made), *checked.failed]
    made = structs.replace(made, gates=GateResult(failed=tuple(failed), improved=checked.improved))
    files.write(made, options.output)
    columns = shutil.get_terminal_size().columns
    failing = FailingTests.of(made, columns)
    for line in (
        *failing.list_causes(columns),
        *terminal.summary(made, options.output, columns, problems=failed),
    ):
        print(harmless_line(line.text))
    return FAILED_RUNS if failed else OK


def _failures(report: Report) -> Iterator[str]:
    """The failures of a campaign besides the gates of a session, a sentence each."""
    result = CAMPAIGN.of(report)
    assert result is not None, "it is a campaign's"
    if result.not_run:
        yield f"{result.not_run:,} of {result.expected:,} runs have no outcome: totals are lower bounds"
    if result.lost:
        yield f"{len(result.lost):,} runs were lost: {list_names(sorted(run.id for run in result.lost), _SHOWN)}"
    if result.differing:
        yield f"{len(result.differing):,} of {result.repeated:,} repeated runs differ elsewhere"
    for outcome in FAILING:
        count = result.outcomes.get(outcome, 0)
        if count:
            names = list_names(sorted(test.id for test in report.tests if test.outcome == outcome), _SHOWN)
            yield f"{count:,} of {result.stored:,} runs: {outcome}: {names}"


def export(options: argparse.Namespace) -> int:
    """Write a row a run for other tools."""
    with closing(Store.open(options.state.resolve())) as store:
        rows = write_parquet(store, store.plan(), options.parquet)
    print(f"{options.parquet}: {rows:,} runs")
    return OK
