"""The audit of a campaign: repeats some runs, on another worker if there is one, and compares the records.

Where they do not, both are asked for their records, and the first event at which they part is kept: what differs
between two machines, or two versions, shows there first.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterator
from hashlib import sha256
from itertools import zip_longest

import msgspec

from pytest_hricdv.extra.campaign.execution import TASK_RUNS, Execution
from pytest_hricdv.extra.campaign.plan import CampaignPlan, RunKey
from pytest_hricdv.extra.campaign.row import LOST
from pytest_hricdv.session.remote import Answer, LostRequest, WorkerName, WorkRequest
from pytest_hricdv.session.run_process import RunReply

PERCENT = 1.0
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
    """Repeat the runs chosen for it that were not repeated yet. Raises as `Execution.run`."""
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
            parting = "" if sha256 == hashes[run.key] else _find_difference(execution, run.key, answer.worker.address)
            store.add_repeat(run.key, sha256, answer.worker, parting)
        execution.on_progress()


def _ask(execution: Execution, queue: deque[WorkRequest]) -> Iterator[tuple[WorkRequest, Answer]]:
    for question, answer in execution.workers.answers(execution.service, queue, execution.on_progress):
        if not isinstance(answer, LostRequest):
            yield question, answer


def _runs(answer: Answer) -> list[RunReply]:
    return [msgspec.json.decode(line, type=RunReply) for line in answer.lines]


def _find_difference(execution: Execution, key: RunKey, there: str) -> str:
    """The first event at which the records of a run part, on the two workers that disagree."""
    first = execution.store.workers()[execution.store.row(key).worker].address
    queue = deque(execution.question([key], avoid=avoid, records=True) for avoid in (first, there))
    records = [(answer.worker, run.record) for _, answer in _ask(execution, queue) for run in _runs(answer)]
    if len(records) < 2:
        return "the records cannot be compared: the run could not be done once more"
    (worker, record), (other, other_record) = sorted(records, key=lambda pair: pair[0].address)
    for number, (here, elsewhere) in enumerate(zip_longest(record, other_record, fillvalue="no further event"), 1):
        if here != elsewhere:
            return f"event {number}: {here} ({_where(worker)}), but {elsewhere} ({_where(other)})"
    return "done once more, both gave the same record: it changes from run to run"


def _where(worker: WorkerName) -> str:
    return f"{worker.host}, {worker.address}"
