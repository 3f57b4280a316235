"""Single tests that no suite has, run on a cluster: for the searches of a session, several of which go on at a time."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import msgspec

from pytest_hricdv.generate.concrete import ConcreteTest, abstract_from
from pytest_hricdv.generate.rng import digest
from pytest_hricdv.monitor import RequirementResult
from pytest_hricdv.session import run_process
from pytest_hricdv.session.identity import identity
from pytest_hricdv.session.remote import Lost, Question, Service, Workers, remote
from pytest_hricdv.session.run_context import RunContext
from pytest_hricdv.session.run_process import RunBatch, RunReply, RunRequest, SessionArguments
from pytest_hricdv.session.serving import arguments_of

RUN_S = 120.0
"""A run that takes longer (s of wall time) is given up: a hundred times what one of the table takes."""


@dataclass
class RemoteRuns:
    """Runs tests on a cluster; of several threads at a time.

    Args:
        address: of the cluster.
        workers: of it.
        service: that is asked.
    """

    address: str
    workers: Workers
    service: Service
    is_over: threading.Event = field(default_factory=threading.Event)
    """Set where nobody waits for runs any more."""

    def run(self, test: ConcreteTest, requirement: str) -> RequirementResult | None:
        """Run a test; what became of a requirement, None where the run came to no end.

        Raises:
            KeyboardInterrupt: it is over.
            ClusterError: the scheduler is gone, or no worker can run it.
        """
        question = Question(digest(test.to_json())[:24], msgspec.json.encode(RunBatch((_request(test),))))
        for _, answer in self.workers.answers(self.service, deque([question]), self._check):
            if not isinstance(answer, Lost) and answer.lines:
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
    """On the cluster that the session's options name; None where they name none.

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
    job = msgspec.json.encode(SessionArguments((*there.arguments, *arguments_of(config))))
    service = there.service(run_process.__name__, job, project, RUN_S)
    with cluster.connect(address, say) as workers:
        yield RemoteRuns(address, workers, service)
