"""`Execution` of a campaign: sends the missing runs to a cluster in tasks, and stores each result as it arrives.

The command `run` uses it, and then `audit`, which repeats some runs, on another worker if there is one, and compares
the records. Of records that differ, the first different event is kept: it shows how two machines, or versions, differ.
"""

from __future__ import annotations

from collections import Counter, defaultdict, deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from hashlib import sha256

import msgspec

from pytest_hricdv.extra.campaign.database import LOST
from pytest_hricdv.extra.campaign.plan import CampaignPlan, RunKey
from pytest_hricdv.extra.campaign.store import Store
from pytest_hricdv.generate.rng import digest
from pytest_hricdv.results.timeline import differing_events
from pytest_hricdv.session import run_process
from pytest_hricdv.session.remote import Answer, LostRequest, RemoteProject, Service, WorkerName, Workers, WorkRequest
from pytest_hricdv.session.run_process import RunBatch, RunReply, SessionArguments

TASK_RUNS = 20
"""Maximum number of runs in a task: seconds of work, so sending it costs little, and so does repeating a lost one."""

SHARES = 4
"""Minimum number of tasks per thread of the workers; tasks of small campaigns have fewer runs for this. At the end,
threads then wait for the last one no longer than a quarter of a thread's work."""

TRIES = 3
"""A run that ends its process this many times is lost. Once may be due to a lack of memory; three times is the run."""


class CancelledError(Exception):
    """Somebody asked the campaign to stop."""


@dataclass
class Execution:
    """Executes the missing runs of a campaign.

    Args:
        run_s: time limit (s of wall time) for a result; without one the process is ended, and its run tried again.
        project: as workers find it.
        on_progress: called whenever something was stored, and from time to time.
    """

    plan: CampaignPlan
    store: Store
    workers: Workers
    run_s: float
    project: RemoteProject
    on_progress: Callable[[], None] = lambda: None
    _tries: Counter[RunKey] = field(default_factory=Counter)

    @property
    def service(self) -> Service:
        """The service of the workers."""
        planned, there = self.plan.planned, self.project
        job = msgspec.json.encode(SessionArguments((*there.arguments, *planned.arguments)))
        return there.service(run_process.__name__, job, planned.project, self.run_s)

    def run(self) -> None:
        """Run what has no outcome yet.

        Raises:
            ClusterError: the scheduler is gone, or no worker can run it.
            CampaignError: the store cannot be written.
            CancelledError: somebody asked to stop.
        """
        done = self.store.keys()
        missing = [key for key in self.plan.run_keys() if key not in done]
        size = min(TASK_RUNS, max(1, len(missing) // (SHARES * max(1, self.workers.threads))))
        tasks = [missing[first : first + size] for first in range(0, len(missing), size)]
        keys: dict[str, list[RunKey]] = {}
        queue: deque[WorkRequest] = deque()
        for task in tasks:
            self._put(task, keys, queue)
        for question, answer in self.workers.answers(self.service, queue, self._tick):
            for again in self._store_answer(keys[question.key], answer):
                self._put(again, keys, queue)
            self.on_progress()

    def _put(self, task: list[RunKey], keys: dict[str, list[RunKey]], queue: deque[WorkRequest]) -> None:
        question = self.question(task)
        keys[question.key] = task
        queue.append(question)

    def question(self, task: Sequence[RunKey], *, avoid: str = "") -> WorkRequest:
        """The question to a worker for these runs."""
        key = digest(sorted(self.plan.planned.project.items()), [self.plan.name(run) for run in task], avoid)
        requests = tuple(map(self.plan.request, task))
        return WorkRequest(key[:24], msgspec.json.encode(RunBatch(requests)), avoid)

    def _store_answer(self, task: list[RunKey], answer: Answer | LostRequest) -> Iterable[list[RunKey]]:
        """Stores what came back; returns the tasks that are to be done again."""
        if isinstance(answer, LostRequest):
            if len(task) == 1:
                self.store.add_lost(task[0], answer.reason)
                return ()
            return ([key] for key in task)
        ran = [msgspec.json.decode(line, type=RunReply) for line in answer.lines]
        for run in ran:
            self.store.add(run.key, run.result, run.replay, answer.worker)
        left = [key for key in task if key not in {run.key for run in ran}]
        if not left:
            return ()
        # A process does its runs in order, so that the first without a result is the one that ended it.
        culprit, others = left[0], left[1:]
        self._tries[culprit] += 1
        if self._tries[culprit] >= TRIES:
            self.store.add_lost(culprit, f"its process: {answer.problem}, {TRIES} times")
            return [others] if others else ()
        return [again for again in ([culprit], others) if again]

    def _tick(self) -> None:
        if self.store.is_cancelled:
            raise CancelledError
        self.on_progress()


AUDIT_PERCENT = 1.0
"""Share of the runs that are repeated. In a campaign of 6,560 runs, a record that differs in one run of twenty is found
with probability 1 - 0.95**65 = 96 %."""

_PARTS = 10_000  # so that shares can be given to a hundredth of a per cent


def select_runs(plan: CampaignPlan, percent: float) -> Iterator[RunKey]:
    """The runs to repeat: by their names, so that the same are whenever and wherever a campaign runs."""
    for key in plan.run_keys():
        number = int.from_bytes(sha256(f"audit {plan.name(key)}".encode()).digest()[:8], "big")
        if number % _PARTS < percent * _PARTS / 100.0:
            yield key


def audit(execution: Execution, percent: float) -> None:
    """Repeat the runs chosen for it that were not repeated yet. Raises the same errors as `Execution.run`."""
    store = execution.store
    repeated = {repeat.key for repeat in store.repeats()}
    done, workers = store.keys(), store.workers()
    by_worker: dict[str, list[RunKey]] = defaultdict(list)
    for key in select_runs(execution.plan, percent):
        if key in done and key not in repeated and (row := store.row(key)).outcome != LOST:
            by_worker[workers[row.worker].address].append(key)
    tasks = {}
    for address, keys in by_worker.items():
        for first in range(0, len(keys), TASK_RUNS):
            question = execution.question(keys[first : first + TASK_RUNS], avoid=address)
            tasks[question.key] = question
    for _, answer in _ask(execution, deque(tasks.values())):
        hashes = store.hashes(run.key for run in _runs(answer))
        for run in _runs(answer):
            sha256 = run.result.record_sha256 or ""
            parting = "" if sha256 == hashes[run.key] else _find_difference(store, run, answer.worker)
            store.add_repeat(run.key, sha256, answer.worker, parting)
        execution.on_progress()


def _ask(execution: Execution, queue: deque[WorkRequest]) -> Iterator[tuple[WorkRequest, Answer]]:
    for question, answer in execution.workers.answers(execution.service, queue, execution.on_progress):
        if not isinstance(answer, LostRequest):
            yield question, answer


def _runs(answer: Answer) -> list[RunReply]:
    return [msgspec.json.decode(line, type=RunReply) for line in answer.lines]


def _find_difference(store: Store, again: RunReply, worker: WorkerName) -> str:
    """The first event at which a run and its repetition part."""
    first = store.workers()[store.row(again.key).worker]
    ((_, result, _),) = store.results([again.key])
    here, there = differing_events(result, again.result)
    return f"{here} ({_where(first)}), but {there} ({_where(worker)})" if here or there else "their timelines are equal"


def _where(worker: WorkerName) -> str:
    return f"{worker.host}, {worker.address}"
