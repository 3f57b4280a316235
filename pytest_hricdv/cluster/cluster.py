"""The session's side of a cluster: questions go out, answers come back, whatever happens to workers in between."""

from __future__ import annotations

import importlib.util
import logging
import threading
import time
import warnings
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from pytest_hricdv.cluster import service as worker_side
from pytest_hricdv.cluster.address import Address, ClusterError
from pytest_hricdv.cluster.identity import plugin_versions
from pytest_hricdv.cluster.service import Answer, Service
from pytest_hricdv.project_files import differences

if TYPE_CHECKING:
    from distributed import Client, Future

AHEAD = 3
"""So many questions a thread are handed out: enough that none waits, and few when a worker is lost with them."""

CONNECT_S, WAIT_FOR_SCHEDULER_S, WAIT_FOR_WORKERS_S = 5.0, 120.0, 60.0
_GONE = (CancelledError, TimeoutError, OSError)
"""The errors of a connection that is gone."""

TICK_S = 0.5
"""What happens without an answer, as a worker that comes or goes, is looked at so often (s)."""


@dataclass(frozen=True)
class Question:
    """What is asked.

    Args:
        key: equal for equal questions only.
        message: a line.
        avoid: the address of a worker that is to leave it to another one, if there is any.
    """

    key: str
    message: bytes
    avoid: str = ""


@dataclass(frozen=True)
class Lost:
    """Nobody answers a question: the workers that were asked were lost, again and again."""

    reason: str


@dataclass
class Cluster:
    """Workers that answer questions. Made by `connected`.

    Args:
        address: of the cluster.
        say: receives what a person should know, a sentence each.
    """

    address: Address
    say: Callable[[str], None]
    refused: dict[str, str] = field(default_factory=dict)
    """Workers that are not asked: address -> why."""
    _client: Client | None = field(default=None, repr=False)
    _local: Any = field(default=None, repr=False)
    _lock: threading.Lock = field(default_factory=threading.Lock, repr=False)
    """Questions may come from several threads."""
    _checked: dict[str, int] = field(default_factory=dict)
    """Workers that may be asked: address -> threads."""

    @property
    def threads(self) -> int:
        """How many questions are answered at a time."""
        return sum(self._checked.values())

    @property
    def dashboard(self) -> str:
        """The address of Dask's own page; empty where it cannot be made."""
        can_be_made = importlib.util.find_spec("bokeh") is not None
        return str(self._client.dashboard_link) if self._client is not None and can_be_made else ""

    def answers(
        self, service: Service, queue: deque[Question], archive: bytes = b"", tick: Callable[[], None] = lambda: None
    ) -> Iterator[tuple[Question, Answer | Lost]]:
        """Ask until the queue is empty, from left to right; questions may be added in the meantime.

        A question whose worker is lost is asked again, of another one.

        Args:
            service: that answers.
            queue: of questions.
            archive: of the project; empty where workers have it.
            tick: called at least twice a second; what it raises ends the questions.

        Raises:
            ClusterError: the scheduler is gone, or no worker can answer.
        """
        pending: dict[Future[Any], Question] = {}
        try:
            while queue or pending:
                tick()
                try:
                    self._look_at_workers()
                    while queue and len(pending) < AHEAD * max(1, self.threads):
                        future = self._submit(service, queue[0], archive)
                        pending[future] = queue.popleft()
                    done = self._done(pending)
                    for future in done:
                        question = pending.pop(future)
                        result = self._result(future, question, queue)
                        if result is not None:
                            yield question, result
                except _GONE as error:
                    queue.extendleft(reversed([*pending.values()]))
                    pending.clear()
                    self._reconnect(error)
        finally:
            with suppress(*_GONE):
                if self._client is not None and pending:
                    self._client.cancel([*pending], force=True)

    def _submit(self, service: Service, question: Question, archive: bytes) -> Future[Any]:
        """Hand a question out; only to workers that may be asked."""
        assert self._client is not None, "it is connected"
        allowed = [each for each in self._checked if each != question.avoid] or [*self._checked]
        limited = bool(self.refused) or bool(question.avoid)
        return self._client.submit(
            worker_side.ask,
            service,
            question.message,
            archive,
            key=f"hricdv-{question.key}-{time.monotonic_ns()}",
            pure=False,
            workers=allowed if limited else None,
            allow_other_workers=bool(question.avoid) and not self.refused,
        )

    def _done(self, pending: Mapping[Future[Any], Question]) -> list[Future[Any]]:
        from distributed import wait

        if not pending:
            return []
        with suppress(TimeoutError):
            wait([*pending], timeout=TICK_S, return_when="FIRST_COMPLETED")
        return [future for future in pending if future.done()]

    def _result(self, future: Future[Any], question: Question, queue: deque[Question]) -> Answer | Lost | None:
        """What came of a question; None where it is asked again."""
        from distributed import KilledWorker

        try:
            answer = future.result(timeout=CONNECT_S)
        except TimeoutError:  # the worker that had the answer is gone: it is asked again
            queue.append(question)
            return None
        except KilledWorker as error:
            return Lost(f"{error.last_worker.address if error.last_worker else 'its workers'} and others were lost")
        assert isinstance(answer, Answer), "it is what a worker returns"
        if not answer.unable:
            return answer
        queue.appendleft(question)
        self._refuse(answer.worker.address, f"{answer.unable} ({answer.worker.host})")
        return None

    def _refuse(self, worker: str, why: str) -> None:
        if worker not in self.refused:
            self.refused[worker] = why
            self.say(f"worker {worker} is not asked: {why}")
        self._checked.pop(worker, None)

    def _look_at_workers(self) -> None:
        with self._lock:
            self._await_workers()

    def _await_workers(self) -> None:
        """Notes which workers there are; each is checked when it is new. Raises ClusterError if there is none."""
        began_s = time.monotonic()
        while True:
            found = self._threads_of_workers()
            self._checked = {worker: threads for worker, threads in self._checked.items() if worker in found}
            new = [worker for worker in found if worker not in self._checked and worker not in self.refused]
            if new:
                self._check({worker: found[worker] for worker in new})
            if self._checked:
                return
            if found and set(found) <= set(self.refused):
                reasons = "; ".join(f"{worker}: {self.refused[worker]}" for worker in sorted(found))
                raise ClusterError(f"{self.address}: no worker can be asked: {reasons}")
            if time.monotonic() - began_s > WAIT_FOR_WORKERS_S:
                raise ClusterError(
                    f"{self.address}: no worker has come in {WAIT_FOR_WORKERS_S:.0f} s: start one with "
                    f"'dask worker {self.address}'"
                )
            time.sleep(TICK_S / 5)  # Dask tells of no worker that comes

    def _threads_of_workers(self) -> dict[str, int]:
        assert self._client is not None, "it is connected"
        if self._client.status != "running":
            raise OSError("the scheduler is gone")
        workers = self._client.scheduler_info(n_workers=-1)["workers"]
        return {address: int(each["nthreads"]) for address, each in workers.items()}

    def _check(self, new: Mapping[str, int]) -> None:
        """Refuses workers with other versions of what both ends need."""
        assert self._client is not None, "it is connected"
        wanted = plugin_versions()
        told = self._client.run(plugin_versions, workers=[*new], on_error="return")
        for worker, threads in new.items():
            found = told.get(worker)
            if isinstance(found, dict) and found == wanted:
                self._checked[worker] = threads
            elif isinstance(found, dict):
                self._refuse(worker, f"its versions are others: {differences(wanted, found)}")
            elif isinstance(found, ImportError):
                self._refuse(worker, f"pytest-hricdv is not installed there ({found})")

    def _reconnect(self, error: Exception) -> None:
        """Connect anew to a scheduler that is gone for a while."""
        if self._local is not None:
            raise ClusterError(f"{self.address}: the workers of this machine are gone: {error}") from None
        self.say(f"the scheduler {self.address} is gone; waiting for it for {WAIT_FOR_SCHEDULER_S:.0f} s ...")
        self._close_client()
        began_s = time.monotonic()
        while True:
            try:
                self._connect()
            except ClusterError:
                if time.monotonic() - began_s > WAIT_FOR_SCHEDULER_S:
                    raise ClusterError(f"{self.address}: the scheduler is gone, and did not return") from None
            else:
                self.say(f"the scheduler {self.address} is back")
                return

    def _connect(self) -> None:
        from distributed import Client

        try:
            if not self.address.scheduler:
                self._local = self._local or _local_cluster(self.address.workers)
            self._client = Client(self._local or self.address.scheduler, timeout=CONNECT_S)
        except (OSError, TimeoutError, ValueError) as error:
            why = str(error).partition("\n")[0]
            raise ClusterError(
                f"{self.address}: no scheduler answers there ({why}): start one with 'dask scheduler', or "
                "give --cluster=local"
            ) from None
        self._checked.clear()
        self.refused.clear()

    def _close_client(self) -> None:
        if self._client is not None:
            with suppress(*_GONE):
                self._client.close(timeout=2)
            self._client = None

    def close(self) -> None:
        """Leave the cluster; the workers of this machine, which are its own, end."""
        if self._client is not None and self._local is None:
            with suppress(*_GONE):
                self._client.run(worker_side.end_processes, wait=True, on_error="return")
        self._close_client()
        if self._local is not None:
            with suppress(*_GONE):
                self._local.close(timeout=5)


@contextmanager
def connected(address: Address, say: Callable[[str], None]) -> Iterator[Cluster]:
    """A cluster, connected.

    Raises:
        ClusterError: Dask distributed is not installed, or there is no scheduler.
    """
    try:
        import distributed  # noqa: F401
    except ImportError:
        raise ClusterError(
            f"{address}: Dask distributed is not installed: pip install 'pytest-hricdv[cluster]'"
        ) from None
    with ExitStack() as stack:
        stack.enter_context(_quiet())
        cluster = Cluster(address, say)
        cluster._connect()
        stack.callback(cluster.close)
        cluster._look_at_workers()
        yield cluster


@contextmanager
def _quiet() -> Iterator[None]:
    """Dask's log says what is said here in fewer words."""
    log = logging.getLogger("distributed")
    before = log.level
    log.setLevel(logging.CRITICAL + 1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            yield
        finally:
            log.setLevel(before)


def _local_cluster(workers: int) -> Any:
    from distributed import LocalCluster

    return LocalCluster(
        n_workers=workers,
        threads_per_worker=1,
        processes=True,
        memory_limit=0,
        dashboard_address=None,
        silence_logs=logging.CRITICAL,
    )
