"""The interface to workers on other machines: `remote` gives the `Remote` of the feature `cluster`, if there is one.

Campaigns, the search and the closing loop connect to `Workers` by it, send them `WorkRequest`s, and get `Answer`s.
A request is a line of text for a process next to a worker, a `Service`; its answer consists of lines, too.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import pytest

from pytest_hricdv._base.hash_seed import hash_seed_of_children
from pytest_hricdv._base.message import InputError
from pytest_hricdv.registry import offers
from pytest_hricdv.session.options import Options


class ClusterError(InputError):
    """The cluster does not exist or cannot work; the message says which, why, and what to do."""


@dataclass(frozen=True)
class Service:
    """A process next to a worker that answers requests.

    Args:
        module: name of the module that it runs.
        job: the first line that it is sent; its answer is an `Identity`.
        directory: where it starts; with an archive, relative to the folder with its files.
        project: files of project and code under test, name -> hash: a worker whose process has other ones refuses.
            Empty: whatever it has.
        silent_s: a process that writes nothing for this time (s of wall time) is ended.
        root: the project's folder, relative to `directory`.
        sources: the files in it, name -> hash: a worker with other ones refuses before it imports any. Empty: it does
            not look.
        archive: the project's archive, where workers do not have it.
        archive_sha256: SHA-256 of that archive.
        hash_seed: the process's hash seed, on whichever machine: that of all that the session starts.
    """

    module: str
    job: bytes
    directory: str
    project: Mapping[str, str]
    silent_s: float
    root: str = "."
    sources: Mapping[str, str] = field(default_factory=dict)
    archive: bytes = field(default=b"", compare=False, repr=False)
    archive_sha256: str = ""
    hash_seed: str = field(default_factory=hash_seed_of_children)


@dataclass(frozen=True)
class WorkRequest:
    """A request to a service, one line.

    Args:
        key: equal for equal requests only.
        message: the line.
        avoid: the address of a worker that leaves the request to another one, if there is any.
    """

    key: str
    message: bytes
    avoid: str = ""


@dataclass(frozen=True)
class WorkerName:
    """A worker: its address, its machine, and the versions installed there."""

    address: str
    host: str
    versions: Mapping[str, str]


@dataclass(frozen=True)
class Answer:
    """The answer of a worker.

    Args:
        worker: which.
        lines: the lines of the answer so far.
        problem: why the process ended before the answer did; empty if it did not.
        unable: why this worker cannot answer any request; empty if it can.
    """

    worker: WorkerName
    lines: tuple[bytes, ...] = ()
    problem: str = ""
    unable: str = ""


@dataclass(frozen=True)
class LostRequest:
    """A request without an answer: each worker that got it was lost."""

    reason: str


class Workers(Protocol):
    """Workers that answer requests, from several threads at a time."""

    @property
    def threads(self) -> int:
        """How many requests are answered at a time."""

    @property
    def dashboard(self) -> str:
        """The address of a page that shows their work; empty if there is none."""

    def answers(
        self, service: Service, queue: deque[WorkRequest], tick: Callable[[], None] = lambda: None
    ) -> Generator[tuple[WorkRequest, Answer | LostRequest]]:
        """Ask until the queue is empty, from left to right; requests may be added in the meantime.

        A request whose worker is lost is asked again, of another one.

        Args:
            service: the service that answers.
            queue: the queue of requests.
            tick: called at least twice a second; what it raises ends the requests.

        Raises:
            ClusterError: the scheduler is gone, or no worker can answer.
        """


class RemoteProject(Protocol):
    """A project, as processes of workers find it."""

    @property
    def arguments(self) -> tuple[str, ...]:
        """The first arguments of pytest."""

    def service(self, module: str, job: bytes, project: Mapping[str, str], silent_s: float) -> Service:
        """A process in that project; see `Service`."""


class Remote(ABC):
    """Workers on other machines."""

    @abstractmethod
    def address(self, text: str) -> str:
        """The address in full, as `local:4` for `local`. Raises ClusterError for an invalid one."""

    @abstractmethod
    def address_of_session(self, options: Options) -> str:
        """The address that the options of a session name; empty: its runs stay here. Raises ClusterError."""

    @abstractmethod
    def project_of_session(self, config: pytest.Config, options: Options) -> RemoteProject:
        """The project of a session. Raises ClusterError if it cannot be sent."""

    @abstractmethod
    def project(
        self, root: Path, here: Path, *, send: bool, state: Path | None = None, hidden: Sequence[str] = ()
    ) -> RemoteProject:
        """The project below a folder.

        Args:
            root: its folder.
            here: where pytest was started; where the project is sent, in that folder.
            send: whether workers are sent it.
            state: the file of a campaign, which is not sent.
            hidden: patterns of hidden files that are sent.

        Raises:
            ClusterError: it cannot be sent.
        """

    @abstractmethod
    def connect(self, address: str, say: Callable[[str], None]) -> AbstractContextManager[Workers]:
        """A cluster with at least one worker.

        Args:
            address: the complete address.
            say: receives what a person should know, a sentence each.

        Raises:
            ClusterError: there is no scheduler, no worker comes, or what it takes is not installed.
        """


def remote() -> Remote | None:
    """Workers on other machines; None if no feature has any."""
    return next(iter(offers("remote", "REMOTE")), None)
