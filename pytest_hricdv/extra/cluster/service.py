"""The worker's side of a cluster: one process for each thread of a worker, which answers one request after the other.

`Cluster` lets workers call `ask`. Runs take place in that process and not in the worker, so a run that crashes or hangs
ends no worker, does not disturb its connection, and is reported by name.
"""

from __future__ import annotations

import atexit
import json
import os
import platform
import threading
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path

import msgspec

from pytest_hricdv._base import project_files
from pytest_hricdv._base.project_files import Identity, differences
from pytest_hricdv.execution.separate_process import ProcessError, SeparateProcess, start_process
from pytest_hricdv.extra.cluster import code_archive
from pytest_hricdv.extra.cluster.private_folder import require_safe
from pytest_hricdv.session.remote import Answer, Service, WorkerName

BEGIN_S = 120.0
"""Time limit (s of wall time) without output while a process loads the project; then it is ended."""


def ask(service: Service, message: bytes) -> Answer:
    """Ask this thread's process, which is started if there is none. Called by Dask, on the worker."""
    asked = _processes.setdefault(threading.get_ident(), _WorkerProcess())
    return asked.answer(service, message)


class OtherProjectError(Exception):
    """A worker has other files; the message says which."""


def _require_same(wanted: Mapping[str, str], present: Mapping[str, str]) -> None:
    """Raise OtherProjectError where files, name -> hash, are others than those that are wanted."""
    differ = differences(wanted, present)
    if differ:
        raise OtherProjectError(differ)


class _WorkerProcess:
    """The process in which one thread of a worker executes requests."""

    def __init__(self) -> None:
        self._service: Service | None = None
        self._stack = ExitStack()
        self._process: SeparateProcess | None = None
        self._identity = Identity({}, {})
        self._directory = Path()
        self._sent: Path | None = None
        """The folder of the project that was sent."""

    def answer(self, service: Service, message: bytes) -> Answer:
        try:
            if self._process is None or self._service != service:
                self._start(service)
        except (ProcessError, OSError) as error:
            self.end()
            return Answer(self._worker, unable=f"it cannot begin: {error}")
        except OtherProjectError as error:
            self.end()
            return Answer(self._worker, unable=f"its project in {self._directory} is another one: {error}")
        assert self._process is not None, "it was started"
        lines: list[bytes] = []
        try:
            self._process.send(message)
            lines.extend(self._process.answer(service.silent_s))  # has those before an error
        except ProcessError as error:
            shown = self._without_folder(lines)
            self.end()
            return Answer(self._worker, shown, str(error))
        return Answer(self._worker, self._without_folder(lines))

    def _without_folder(self, lines: list[bytes]) -> tuple[bytes, ...]:
        """Lines of an answer without the name of the folder with the project, which is another one each time."""
        if self._sent is None:
            return tuple(lines)
        folder = json.dumps(str(self._sent))[1:-1].encode()
        separator = json.dumps(os.sep)[1:-1].encode()
        return tuple(line.replace(folder + separator, b"").replace(folder, b".") for line in lines)

    @property
    def _worker(self) -> WorkerName:
        return WorkerName(_address(), platform.node(), self._identity.versions)

    def _start(self, service: Service) -> None:
        self.end()
        scratch = _scratch()
        require_safe(scratch)  # Python looks for modules in it first
        self._directory = self._folder(service, scratch) / service.directory
        if service.sources:
            _require_same(service.sources, project_files.hashes((self._directory / service.root).resolve()))
        self._process = self._stack.enter_context(
            start_process(service.module, self._directory, hash_seed=service.hash_seed)
        )
        self._process.send(service.job)
        *_, identity = self._process.answer(max(service.silent_s, BEGIN_S))
        self._identity = msgspec.json.decode(identity, type=Identity)
        if service.project:
            _require_same(service.project, self._identity.project)
        self._service = service

    def _folder(self, service: Service, scratch: Path) -> Path:
        """The folder that the service's directory is in: a new one with the project that was sent, or any."""
        if not service.archive_sha256:
            return Path()
        self._sent = self._stack.enter_context(code_archive.unpack(service.archive, scratch))
        return self._sent

    def end(self) -> None:
        """End the process."""
        self._stack.close()
        self._process = self._service = self._sent = None


_processes: dict[int, _WorkerProcess] = {}
"""Thread -> its process. A worker's own: what is in it is not a result, and ends with the worker."""


def end_processes() -> None:
    """End this worker's processes: at its end, and where nothing more is to be asked."""
    for asked in list(_processes.values()):
        asked.end()


atexit.register(end_processes)


def _scratch() -> Path:
    """The folder that Dask has made for this worker's files: it removes what a worker that was killed leaves there."""
    from distributed import get_worker

    return Path(get_worker().local_directory)


def _address() -> str:
    from distributed import get_worker  # within a worker it is there

    return str(get_worker().address)
