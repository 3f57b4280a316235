"""The worker's side: a process beside each thread of a worker, which is asked, and which survives from one to the next.

Runs take place in that process and not in the worker: so a run that crashes or hangs costs no worker, is known by name,
and leaves the connection to the scheduler alone.
"""

from __future__ import annotations

import atexit
import platform
import threading
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

import msgspec

from pytest_hricdv._base.hash_seed import hash_seed_of_children
from pytest_hricdv._base.project_files import differences
from pytest_hricdv.execution.separate_process import ProcessError, SeparateProcess, started
from pytest_hricdv.extra.cluster import code_archive
from pytest_hricdv.session.identity import Identity


@dataclass(frozen=True)
class Service:
    """What answers.

    Args:
        module: name of the module that a process runs.
        job: the first line that it is sent; its answer is an `Identity`.
        directory: where it starts; with an archive, relative to the folder with its files.
        project: the project's files, name -> hash; a worker with other ones refuses. Empty: whatever it has.
        silent_s: a process that writes nothing for so long (s of wall time) is ended.
        hash_seed: of the processes, on whichever machine: that of all that the session starts.
    """

    module: str
    job: bytes
    directory: str
    project: Mapping[str, str]
    silent_s: float
    hash_seed: str = field(default_factory=hash_seed_of_children)


@dataclass(frozen=True)
class WorkerName:
    """Who answered: the worker's address, its machine, and what is installed there."""

    address: str
    host: str
    versions: Mapping[str, str]


@dataclass(frozen=True)
class Answer:
    """What a worker answered.

    Args:
        worker: which.
        lines: of the answer, as far as there are.
        problem: why the process ended before the answer did; empty where it did not.
        unable: why this worker cannot answer any question; empty where it can.
    """

    worker: WorkerName
    lines: tuple[bytes, ...] = ()
    problem: str = ""
    unable: str = ""


def ask(service: Service, message: bytes, archive: bytes = b"") -> Answer:
    """Ask this worker's process, which is started where there is none. Run by Dask, on the worker.

    Args:
        message: a line.
        archive: of the project; empty where the worker has it.
    """
    asked = _processes.setdefault(threading.get_ident(), _Asked())
    return asked.answer(service, message, archive)


class _Asked:
    """The process of a thread."""

    def __init__(self) -> None:
        self._service: Service | None = None
        self._stack = ExitStack()
        self._process: SeparateProcess | None = None
        self._identity = Identity({}, {})
        self._directory = Path()

    def answer(self, service: Service, message: bytes, archive: bytes) -> Answer:
        try:
            if self._process is None or self._service != service:
                self._start(service, archive)
        except (ProcessError, OSError) as error:
            self.end()
            return Answer(self._worker, unable=f"it cannot begin: {error}")
        differ = differences(service.project, self._identity.project) if service.project else ""
        if differ:
            return Answer(self._worker, unable=f"its project in {self._directory} is another one: {differ}")
        assert self._process is not None, "it was started"
        lines: list[bytes] = []
        try:
            self._process.send(message)
            self._read(self._process, service.silent_s, lines)
        except ProcessError as error:
            self.end()
            return Answer(self._worker, tuple(lines), str(error))
        return Answer(self._worker, tuple(lines))

    @property
    def _worker(self) -> WorkerName:
        return WorkerName(_address(), platform.node(), self._identity.versions)

    def _start(self, service: Service, archive: bytes) -> None:
        self.end()
        self._directory = (code_archive.unpacked(archive) if archive else Path()) / service.directory
        self._process = self._stack.enter_context(started(service.module, self._directory, hash_seed=service.hash_seed))
        self._process.send(service.job)
        lines: list[bytes] = []
        self._read(self._process, service.silent_s, lines)
        self._identity, self._service = msgspec.json.decode(lines[-1], type=Identity), service

    def _read(self, process: SeparateProcess, silent_s: float, lines: list[bytes]) -> None:
        """Takes an answer; ends the process when it is silent for too long."""
        too_long = threading.Event()

        def end() -> None:
            too_long.set()
            process.kill()

        watch = threading.Timer(silent_s, end)
        watch.start()
        try:
            for line in process.answer():
                watch.cancel()
                lines.append(line)
                watch = threading.Timer(silent_s, end)
                watch.start()
        except ProcessError:
            if too_long.is_set():
                raise ProcessError(f"no sign of life for {silent_s:g} s") from None
            raise
        finally:
            watch.cancel()

    def end(self) -> None:
        """End the process."""
        self._stack.close()
        self._process = self._service = None


_processes: dict[int, _Asked] = {}
"""Thread -> its process. A worker's own: what is in it is not a result, and ends with the worker."""


def end_processes() -> None:
    """End this worker's processes: at its end, and where nothing more is to be asked."""
    for asked in list(_processes.values()):
        asked.end()


atexit.register(end_processes)


def _address() -> str:
    from distributed import get_worker  # within a worker it is there

    return str(get_worker().address)
