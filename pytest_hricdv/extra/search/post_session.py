"""`PostSession`: shrinks failures (`--hri-shrink`) and searches for violations (`--hri-search`) after the last test.

`SearchFeature` calls it. A `Shrinker` shrinks tests; a `ViolationSearch` searches, here or on a cluster (`RemoteRuns`).
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import msgspec
from msgspec.structs import replace

from pytest_hricdv._base.hash_seed import question_of_drawn_seed
from pytest_hricdv._base.project_files import identity
from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.execution.hri_case import HriCase
from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.experiments.failure_signature import FailureSignature, failure_signature, has_signature
from pytest_hricdv.experiments.shrink import Shrunk, shrink
from pytest_hricdv.extra.search.records import SHRUNK, SearchOptions, SearchResult, ShrunkTest
from pytest_hricdv.extra.search.violation_search import ViolationSearch
from pytest_hricdv.generate.concrete import ConcreteTest, abstract_from
from pytest_hricdv.generate.rng import digest
from pytest_hricdv.monitor import Criterion, RequirementResult
from pytest_hricdv.report.formatting import seconds
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.results.replay import ReplayOrigin
from pytest_hricdv.session import run_process
from pytest_hricdv.session.child_process import session_arguments
from pytest_hricdv.session.options import Options
from pytest_hricdv.session.remote import LostRequest, Service, Workers, WorkRequest, remote
from pytest_hricdv.session.replaying import TestRerunner, name_test
from pytest_hricdv.session.run_context import RunContext
from pytest_hricdv.session.run_process import RunBatch, RunReply, RunRequest, SessionArguments

ELSEWHERE = "it did not fail again outside of its test function: does a fixture change what the run depends on?"


def shortest_failures(results: Iterable[TestResult], requirements: Iterable[Criterion]) -> dict[str, TestResult]:
    """Requirement -> the shortest test that failed it, by actions and then by id; where one did.

    A test that is outside of the condition under which violations are known comes before the others.
    """
    shortest = {}
    by_length = sorted(results, key=lambda result: (len(result.abstract), result.id, result.nodeid))
    for requirement in requirements:
        failed = [result for result in by_length if result.violates(requirement.id)]
        if failed:
            shortest[requirement.id] = min(failed, key=lambda result: not result.requirements[requirement.id].outside)
    return shortest


@dataclass
class Shrinker:
    """Makes a failure as short as possible: a test, and the requirement that it failed.

    One process does it at the end, not each worker when a test fails: so the result does not depend on how tests were
    distributed over workers, and no requirement is shrunk twice.

    Args:
        requirement: the requirement that failed.
        case: the test that failed it.
        nodeid: the node id of the pytest item that ran it.
    """

    rerunner: TestRerunner
    requirement: Criterion
    case: HriCase
    nodeid: str

    def __post_init__(self) -> None:
        self._wanted: FailureSignature | None = None
        self._outside = False
        self._best: CaseResult | None = None

    def shrink(self, budget: Budget) -> ShrunkTest:
        """Shrink it; keeps the result as a replay file."""
        try:
            if budget.runs > 0:
                budget.spend()
                self._learn_reason()
        except KeyboardInterrupt:
            return self._record(Shrunk(self.case.concrete, budget.used, budget.age_s, "interrupted"))
        if self._best is None:
            return self._record(
                Shrunk(self.case.concrete, budget.used, budget.age_s, "done"), ELSEWHERE + question_of_drawn_seed()
            )
        return self._record(shrink(self.case.concrete, self.case.ranges, self._fails, budget))

    def _learn_reason(self) -> None:
        result = self._run(self.case.concrete)
        verdict = result and result.verdict(self.requirement.id)
        if verdict and verdict.violations:
            wanted = next((violation for violation in verdict.violations if violation.outside), verdict.violations[0])
            self._wanted, self._outside = failure_signature(self.requirement, verdict, wanted), wanted.outside
            self._best = result

    def _fails(self, test: ConcreteTest) -> bool:
        result = self._run(test)
        if result is None or self._wanted is None:
            return False
        verdict = result.verdict(self.requirement.id)
        same = has_signature(self.requirement, self._wanted, verdict, outside=self._outside)
        if same:
            self._best = result
        return same

    def _run(self, test: ConcreteTest) -> CaseResult | None:
        # Under the id that the test will have: a run is a function of all of its test.
        return self.rerunner.run(name_test(test, f"{self.requirement.id}-{SHRUNK.name}"))

    def _record(self, shrunk: Shrunk, note: str = "") -> ShrunkTest:
        made, replay = None, None
        if self._best is not None and shrunk.test != self.case.concrete:
            origin = ReplayOrigin("shrunk", self.case.abstract.id, self.requirement.id, shrunk.runs)
            made, replay = self.rerunner.keep(self.case, self._best, self.nodeid, origin)
        return ShrunkTest(
            id=None if made is None else made.abstract.id,
            replay=replay,
            abstract=tuple(action.command for action in shrunk.test.actions),
            concrete=tuple(self.case.ranges.describe(shrunk.test)),
            actions_before=len(self.case.concrete.actions),
            runs=shrunk.runs,
            wall_s=round(shrunk.wall_s, 3),
            end_reason=shrunk.ended,
            reason=tuple(self._wanted or ()),
            note=note,
            course=() if self._best is None else tuple(_course(self._best, self.requirement)),
        )


def _course(result: CaseResult, requirement: Criterion) -> Iterator[str]:
    """What each of several actors began when, up to the violation; nothing for one actor, who acts in order."""
    violations = result.verdict(requirement.id).violations
    if len(result.test.actors) < 2 or not violations:
        return
    violated_s = violations[0].time_s
    for time_s, number in zip(result.action_times_s, result.begun, strict=True):
        if time_s <= violated_s:
            yield f"{seconds(time_s)} {result.test.actions[number].command}"
    yield f"{seconds(violated_s)} {requirement.id} is violated"


RUN_S = 120.0
"""A run that takes longer (s of wall time) is given up: a hundred times what one of the table takes."""


@dataclass
class RemoteRuns:
    """Runs tests on a cluster; of several threads at a time.

    Args:
        service: the service that is asked.
    """

    address: str
    workers: Workers
    service: Service
    is_over: threading.Event = field(default_factory=threading.Event)
    """Set when nobody waits for runs any more."""

    def run(self, test: ConcreteTest, requirement: str) -> RequirementResult | None:
        """Run a test; the result on a requirement, None if the run did not end.

        Raises:
            KeyboardInterrupt: it is over.
            ClusterError: the scheduler is gone, or no worker can run it.
        """
        question = WorkRequest(digest(test.to_json())[:24], msgspec.json.encode(RunBatch((_request(test),))))
        for _, answer in self.workers.answers(self.service, deque([question]), self._check):
            if not isinstance(answer, LostRequest) and answer.lines:
                result = msgspec.json.decode(answer.lines[0], type=RunReply).result
                return None if result.outcome == "error" else result.requirements[requirement]
        return None

    def _check(self) -> None:
        if self.is_over.is_set():
            raise KeyboardInterrupt


def _request(test: ConcreteTest) -> RunRequest:
    return RunRequest((0, 0), test.suite, 0, test.id, abstract_from(test, "search", keeps_id=True).to_data())


@contextmanager
def remote_runs(context: RunContext, say: Callable[[str], None]) -> Iterator[RemoteRuns | None]:
    """Runs on the cluster that the session's options name; None without one.

    Raises:
        ClusterError: there is no such cluster.
    """
    collection, cluster = context.collection, remote()
    options, config = collection.options, collection.config
    address = "" if cluster is None else cluster.address_of_session(options)
    if cluster is None or not address:
        yield None
        return
    there = cluster.project_of_session(config, options)
    project = identity(Path(config.rootpath), context.provenance.code).project
    job = msgspec.json.encode(SessionArguments((*there.arguments, *session_arguments(config))))
    service = there.service(run_process.__name__, job, project, RUN_S)
    with cluster.connect(address, say) as workers:
        yield RemoteRuns(address, workers, service)


Searched = tuple[Criterion, SearchResult, HriCase | None]
"""A requirement, what a search for its violation came to, and the test that violates it where one was found."""


@dataclass
class PostSession:
    """Shrinks and searches; stops at Ctrl-C, and keeps what was found until then.

    Args:
        settings: how to shrink and to search.
        chosen: node id -> test, of the session.
        remote: the cluster that runs tests of searches; None: they run here.
    """

    rerunner: TestRerunner
    options: Options
    settings: SearchOptions
    chosen: Mapping[str, HriCase]
    say: Callable[[str], None]
    remote: RemoteRuns | None = None
    interrupted: bool = field(default=False, init=False)
    problems: list[str] = field(default_factory=list, init=False)
    """Violations that were found and are not known."""
    searched: dict[str, SearchResult] = field(default_factory=dict, init=False)
    """What searches have come to."""

    def shrink(self, results: Iterable[TestResult]) -> list[TestResult]:
        """Shrink the shortest failure of each requirement; returns the results, with what they were shrunk to."""
        requirements = {requirement.id: requirement for requirement in self.rerunner.settings.requirements}
        by_nodeid = {result.nodeid: result for result in results}
        for name, failed in shortest_failures(by_nodeid.values(), requirements.values()).items():
            if not self.interrupted:
                shrunk = self._shrunk(requirements[name], self.chosen[failed.nodeid], failed.nodeid)
                result = by_nodeid[failed.nodeid]
                by_nodeid[failed.nodeid] = SHRUNK.put(result, {**SHRUNK.of(result), name: shrunk})
        return [*by_nodeid.values()]

    def _shrunk(self, requirement: Criterion, case: HriCase, nodeid: str) -> ShrunkTest:
        self.say(f"hricdv: shrinking {case.abstract.id}, which failed {requirement.id} ...")
        budget = Budget(self.settings.shrink_runs, self.settings.shrink_seconds)
        shrunk = Shrinker(self.rerunner, requirement, case, nodeid).shrink(budget)
        self.interrupted = shrunk.end_reason == "interrupted"
        return shrunk

    def search(self, results: Iterable[TestResult]) -> dict[str, SearchResult]:
        """Search for a violation of each requirement."""
        for requirement, record, made in self._search_each(list(results)):
            if self.interrupted:
                break
            self.interrupted = record.end_reason == "interrupted"
            conditions = self.rerunner.settings.known_when
            tolerated = requirement.id in self.options.known_violations and requirement.id not in conditions
            if record.status == "violated" and (self.options.strict or not tolerated):
                self.problems.append(f"{requirement.id} is violated by a test that a search found: {record.id}")
            if made is not None and self.settings.shrink and not self.interrupted:
                record = replace(record, shrunk=self._shrunk(requirement, made, made.abstract.id))
            self.searched[requirement.id] = record
        return self.searched

    def _search_each(self, results: list[TestResult]) -> Iterator[Searched]:
        """Search for each requirement: here one after the other, on a cluster several at a time."""
        remote, requirements = self.remote, self.rerunner.settings.requirements
        judged = None if remote is None else remote.run
        searching = ViolationSearch(self.rerunner, self.chosen, self.options.seed, judged)

        def search(requirement: Criterion) -> Searched:
            return requirement, *searching.search(requirement, results, Budget(self.settings.search))

        if remote is None:
            for requirement in requirements:
                self.say(f"hricdv: searching for a violation of {requirement.id} ...")
                yield search(requirement)
            return
        where = f"{len(requirements)} requirements on {remote.address}"
        self.say(f"hricdv: searching for violations of {where} ...")
        with ThreadPoolExecutor(max_workers=max(1, remote.workers.threads)) as pool:
            searches = pool.map(search, requirements)
            try:
                for _ in requirements:
                    with self.rerunner.let_through():
                        ended = next(searches)
                    yield ended
            except KeyboardInterrupt:
                self.interrupted = True
                remote.is_over.set()
