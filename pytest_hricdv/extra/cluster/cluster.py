"""`Cluster`, the session's side: sends requests to workers and collects their answers, even if workers are lost.

`DaskCluster` gets one from `connect`, for an `Address`: the closing loop, searches and campaigns use it.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from pytest_hricdv._base.project_files import differences, plugin_versions
from pytest_hricdv.extra.cluster import service as worker_side
from pytest_hricdv.extra.cluster.connection import CONNECT_S, GONE, Address, Connection, connection
from pytest_hricdv.session.remote import Answer, ClusterError, LostRequest, Service, WorkRequest

if TYPE_CHECKING:
    from distributed import Future

AHEAD = 3
"""Maximum number of open requests per thread of a worker: one in work, one waiting, one on its way. So no thread idles,
and few requests are lost with a worker."""

# Chosen: a job scheduler starts workers within a minute or not soon; a process of this machine imports Dask in seconds,
# and in 20 s where 25 others want the same two cores.
WAIT_FOR_WORKERS_S, WAIT_FOR_LOCAL_S = 60.0, 30.0

TICK_S = 0.5
"""Period (s) of checks for workers that have joined or left."""


@dataclass
class Cluster:
    """The workers that answer requests. `connect` makes it.

    Args:
        say: receives what a person should know, a sentence each.
        connection: the connection to its scheduler.
    """

    address: Address
    say: Callable[[str], None]
    connection: Connection
    refused: dict[str, str] = field(default_factory=dict)
    """Workers that are not asked: address -> why."""
    _lock: threading.Lock = field(default_factory=threading.Lock, repr=False)
    """Requests may come from several threads."""
    _checked: dict[str, int] = field(default_factory=dict)
    """Workers that may be asked: address -> threads."""

    @property
    def dashboard(self) -> str:
        """The address of the scheduler's page; empty if it has none."""
        return self.connection.dashboard

    @property
    def threads(self) -> int:
        """The number of requests answered at a time."""
        return sum(self._checked.values())

    def answers(
        self, service: Service, queue: deque[WorkRequest], tick: Callable[[], None] = lambda: None
    ) -> Generator[tuple[WorkRequest, Answer | LostRequest]]:
        """See `session.remote.Workers`."""
        pending: dict[Future[Any], WorkRequest] = {}
        try:
            while queue or pending:
                tick()
                try:
                    self.look_at_workers()
                    while queue and len(pending) < AHEAD * max(1, self.threads):
                        future = self._submit(service, queue[0])
                        pending[future] = queue.popleft()
                    for future in self._wait(pending):
                        result = self._result(future, pending[future], queue)
                        request = pending.pop(future)
                        if result is not None:
                            yield request, result
                except GONE as error:
                    queue.extendleft(reversed([*pending.values()]))  # extendleft reverses the order
                    pending.clear()
                    self._renew(error)
        finally:
            with suppress(*GONE):
                if pending:
                    self.connection.client.cancel([*pending], force=True)

    def _renew(self, error: Exception) -> None:
        """The scheduler is gone, and with it all that was asked. Raises ClusterError if it stays away."""
        with self._lock:
            self.connection.renew(error)
            self._checked.clear()
            self.refused.clear()

    def _submit(self, service: Service, request: WorkRequest) -> Future[Any]:
        """Hand a request out; only to workers that may be asked."""
        allowed = [address for address in self._checked if address != request.avoid] or [*self._checked]
        limited = bool(self.refused) or bool(request.avoid)
        return self.connection.client.submit(
            worker_side.ask,
            service,
            request.message,
            # Never a key twice: Dask would hand out the answer that it has, and audits ask the same again on purpose.
            key=f"hricdv-{request.key}-{time.monotonic_ns()}",
            pure=False,
            workers=allowed if limited else None,
            allow_other_workers=bool(request.avoid) and not self.refused,
        )

    def _wait(self, pending: Mapping[Future[Any], WorkRequest]) -> list[Future[Any]]:
        from distributed import wait

        if not pending:
            return []
        with suppress(TimeoutError):
            wait([*pending], timeout=TICK_S, return_when="FIRST_COMPLETED")
        return [future for future in pending if future.done()]

    def _result(
        self, future: Future[Any], request: WorkRequest, queue: deque[WorkRequest]
    ) -> Answer | LostRequest | None:
        """The result of a request; None if it is asked again."""
        from distributed import KilledWorker

        try:
            answer = future.result(timeout=CONNECT_S)
        except TimeoutError:  # the worker that had the answer is gone: it is asked again
            queue.append(request)
            return None
        except KilledWorker as error:
            last = f", the last of them {error.last_worker.address}" if error.last_worker else ""
            return LostRequest(f"{error.allowed_failures + 1} workers were lost with it{last}")
        assert isinstance(answer, Answer), "it is what a worker returns"
        if not answer.unable:
            return answer
        queue.appendleft(request)
        self._refuse(answer.worker.address, f"{answer.unable} ({answer.worker.host})")
        return None

    def _refuse(self, worker: str, why: str) -> None:
        if worker not in self.refused:
            self.refused[worker] = why
            self.say(f"worker {worker} is not used: {why}")
        self._checked.pop(worker, None)

    def look_at_workers(self) -> None:
        """Update the list of workers; wait for the first. Raises ClusterError if none comes, or none can be used."""
        with self._lock:
            self._await_workers()

    def _await_workers(self) -> None:
        """As `look_at_workers`, with the lock held; new workers are checked."""
        began_s = time.monotonic()
        while True:
            present = self._threads_of_workers()
            self._checked = {worker: threads for worker, threads in self._checked.items() if worker in present}
            new = [worker for worker in present if worker not in self._checked and worker not in self.refused]
            if new:
                self._check({worker: present[worker] for worker in new})
            if self._checked:
                return
            if present and set(present) <= set(self.refused):
                reasons = "; ".join(f"{worker}: {self.refused[worker]}" for worker in sorted(present))
                raise ClusterError(f"{self.address}: no worker can be used: {reasons}")
            waited_s = time.monotonic() - began_s
            if self.connection.is_local and waited_s > WAIT_FOR_LOCAL_S:
                raise OSError(f"no worker in {WAIT_FOR_LOCAL_S:.0f} s")
            if waited_s > WAIT_FOR_WORKERS_S:
                raise ClusterError(
                    f"{self.address}: no worker has come in {WAIT_FOR_WORKERS_S:.0f} s: start one with "
                    f"'dask worker {self.address}'"
                )
            time.sleep(TICK_S / 5)  # not a synchronization: it polls for a worker that may be used

    def _threads_of_workers(self) -> dict[str, int]:
        if not self.connection.is_open:
            raise OSError("the scheduler is gone")
        # -1: all of them, which is not the default of all versions of Dask.
        workers = self.connection.client.scheduler_info(n_workers=-1)["workers"]
        return {address: int(worker["nthreads"]) for address, worker in workers.items()}

    def _check(self, new: Mapping[str, int]) -> None:
        """Refuses workers with other versions of what both ends need."""
        wanted = plugin_versions()
        versions = self.connection.client.run(plugin_versions, workers=[*new], on_error="return")
        for worker, threads in new.items():
            own = versions.get(worker)
            if isinstance(own, dict) and own == wanted:
                self._checked[worker] = threads
            elif isinstance(own, dict):
                self._refuse(worker, f"its versions differ: {differences(wanted, own)}")
            elif isinstance(own, ImportError):
                self._refuse(worker, f"pytest-hricdv is not installed there ({own})")


@contextmanager
def connect(address: Address, say: Callable[[str], None]) -> Iterator[Cluster]:
    """A cluster with at least one worker.

    Raises:
        ClusterError: Dask distributed is not installed, there is no scheduler, or no worker comes.
    """
    with connection(address, say) as made:
        cluster = Cluster(address, say, made)
        cluster.look_at_workers()
        yield cluster
