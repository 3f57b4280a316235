"""`Connection` to a Dask scheduler, which is restored after the scheduler was unavailable; `Cluster` has one.

`connection` makes it from an `Address`. For `local:N`, it starts `LocalWorkers`, which accept this session only.
"""

from __future__ import annotations

import copy
import importlib.util
import logging
import os
import re
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pytest_hricdv._base.message import quote
from pytest_hricdv.extra.cluster import service as worker_side
from pytest_hricdv.extra.cluster.private_folder import UnsafeFolderError, private_folder
from pytest_hricdv.session.remote import ClusterError

if TYPE_CHECKING:
    from distributed import Client, LocalCluster
    from distributed.security import Security

_HERE = "127.0.0.1"
_NO_ROUTES: dict[str, list[str]] = {"distributed.scheduler.http.routes": [], "distributed.worker.http.routes": []}
"""Removes all pages of Dask's HTTP servers, which cannot be switched off and check no credentials: they answer 404."""


class LocalWorkers:
    """A scheduler and workers on this machine.

    They listen on loopback only, and accept only connections with credentials that exist in the memory of this object;
    so they refuse other users and programs. Their files are in a folder for this user only: Dask's default folder,
    `dask-scratch-space`, may be another user's, and Python looks for modules in it.

    Raises:
        ClusterError: there can be no such cluster on this machine.
    """

    def __init__(self, workers: int) -> None:
        self._stack = ExitStack()
        try:
            folder = self._stack.enter_context(private_folder("workers"))
            self._stack.callback(_forget, str(folder))
            self.cluster: LocalCluster = _start_cluster(workers, str(folder), _local_credentials())
        except UnsafeFolderError as error:
            raise ClusterError(f"local:{workers}: {error}") from None
        except BaseException:
            self._stack.close()
            raise

    def close(self, errors: tuple[type[Exception], ...]) -> None:
        """End them.

        Args:
            errors: the errors of a connection that is gone, which do not matter now.
        """
        with self._stack:
            with suppress(*errors):
                self.cluster.close(timeout=5)
            folder = getattr(self.cluster.scheduler, "_workdir", None)
            if folder is not None:
                folder.release()  # otherwise Dask does so at the end of the process, and complains that it is gone


def _forget(folder: str) -> None:
    """Python looks no longer for modules where Dask has said: a folder of that name may be made when it is gone."""
    sys.path[:] = [entry for entry in sys.path if not entry.startswith(folder)]


def _local_credentials() -> Security:
    """A key, and a certificate that only it can show."""
    from distributed.security import Security

    try:
        made: Security = Security.temporary()
    except ImportError:
        raise ClusterError(
            "local: the package cryptography, with which workers of this machine are kept from others, is not "
            "installed: pip install 'pytest-hricdv[cluster]'"
        ) from None
    return made


def _start_cluster(workers: int, folder: str, credentials: Security) -> LocalCluster:
    import dask
    from distributed import LocalCluster

    with dask.config.set(_NO_ROUTES):
        config: dict[str, Any] = {"distributed": copy.deepcopy(dask.config.get("distributed"))}
        return LocalCluster(
            n_workers=workers,
            threads_per_worker=1,
            processes=True,
            host=_HERE,
            protocol="tls://",
            security=credentials,
            dashboard_address=f"{_HERE}:0",  # with None, Dask listens as well, on a port that can be foreseen
            scheduler_kwargs={"local_directory": folder, "dashboard": False},
            local_directory=folder,
            config=config,  # of workers that are started later, too
            memory_limit=0,  # none: runs take place in other processes, and a worker that is restarted loses them
            silence_logs=logging.CRITICAL,
        )


# A scheduler that is up answers in milliseconds; one that its service restarts is back in two minutes.
CONNECT_S, WAIT_FOR_SCHEDULER_S = 5.0, 120.0
CONNECT_LOCALLY_S = 60.0
"""Time limit (s) for a scheduler in this process; next to 25 processes on two cores it takes over 5 s."""

MAX_RESTARTS = 20
"""Restarts of the workers of this machine, which end where a run kills its worker."""

UNENCRYPTED = (
    "warning: {address} is neither encrypted nor authenticated: whoever reaches its port can run code as the users of "
    "its workers and of this session, and read the project; give it TLS (docs/campaigns.md, 'TLS') and a tls:// address"
)

CREDENTIALS = (
    "PEM files of the CA, of a certificate and of its key, as DASK_DISTRIBUTED__COMM__TLS__CA_FILE, "
    "DASK_DISTRIBUTED__COMM__TLS__CLIENT__CERT and ...__CLIENT__KEY name them (docs/campaigns.md, 'TLS')"
)

GONE = (CancelledError, TimeoutError, OSError)
"""The errors of a connection that is gone."""


_SCHEDULER = re.compile(r"(?:tcp|tls|ws|wss)://\S+:\d+")
_LOCAL = re.compile(r"local(?::(\d{1,4}))?")


@dataclass(frozen=True)
class Address:
    """The address of a cluster.

    Args:
        scheduler: its address; empty for workers on this machine.
        workers: number of workers on this machine.
    """

    scheduler: str = ""
    workers: int = 0

    @classmethod
    def parse(cls, text: str) -> Address:
        """Parse an option's value. Raises ClusterError."""
        local = _LOCAL.fullmatch(text)
        if local is not None:
            workers = int(local[1]) if local[1] else os.cpu_count() or 1
            if workers < 1:
                raise ClusterError(f"{quote(text)}: expected at least one worker, as in local:2")
            return cls(workers=workers)
        if _SCHEDULER.fullmatch(text):
            return cls(scheduler=text)
        raise ClusterError(f"{quote(text)}: expected local, local:WORKERS or a scheduler's tcp://HOST:PORT")

    @property
    def is_encrypted(self) -> bool:
        """Whether both ends are authenticated and all is encrypted; always true for workers on this machine."""
        return not self.scheduler or self.scheduler.startswith(("tls://", "wss://"))

    def __str__(self) -> str:
        return self.scheduler or f"local:{self.workers}"


class Connection:
    """The connection to a scheduler.

    Args:
        address: the address of the scheduler; where it says so, scheduler and workers are started on this machine.
        say: receives what a person should know, a sentence each.

    Raises:
        ClusterError: there is no scheduler.
    """

    def __init__(self, address: Address, say: Callable[[str], None]) -> None:
        self._address = address
        self._say = say
        self._local: LocalWorkers | None = None
        self._restarts = 0
        self.client: Client = self._connect()

    @property
    def dashboard(self) -> str:
        """The address of Dask's own page; empty if it cannot be made."""
        return str(self.client.dashboard_link) if importlib.util.find_spec("bokeh") is not None else ""

    @property
    def is_local(self) -> bool:
        """Whether the workers are on this machine, and belong to this connection."""
        return self._local is not None

    @property
    def is_open(self) -> bool:
        """Whether the scheduler is there, as far as is known."""
        return bool(self.client.status == "running")

    def renew(self, error: Exception) -> None:
        """Reconnect to a scheduler that is gone for a while; everything that it knew is lost.

        Raises:
            ClusterError: it does not return.
        """
        if self._local is not None:
            self._restart(error)
            return
        self._say(f"the scheduler {self._address} is gone; waiting for it for {WAIT_FOR_SCHEDULER_S:.0f} s ...")
        self._close_client()
        began_s = time.monotonic()
        while True:
            try:
                self.client = self._connect()
            except ClusterError:
                if time.monotonic() - began_s > WAIT_FOR_SCHEDULER_S:
                    raise ClusterError(f"{self._address}: the scheduler is gone, and did not return") from None
            else:
                self._say(f"the scheduler {self._address} is back")
                return

    def _restart(self, error: Exception) -> None:
        """Restart scheduler and workers of this machine: nannies give up on workers that die when they start."""
        self._restarts += 1
        if self._restarts > MAX_RESTARTS:
            raise ClusterError(f"{self._address}: the workers of this machine keep ending: {error}") from None
        self._say("the workers of this machine are gone: others are started")
        self._close_client()
        self._close_local()
        self._local = None
        self.client = self._connect()

    def _connect(self) -> Client:
        from distributed import Client

        try:
            if not self._address.scheduler:
                self._local = self._local or LocalWorkers(self._address.workers)
                return Client(self._local.cluster, timeout=CONNECT_LOCALLY_S)
            return Client(self._address.scheduler, security=_credentials(self._address), timeout=CONNECT_S)
        except (OSError, TimeoutError, ValueError, RuntimeError) as error:  # the last one: Dask's settings forbid it
            why = str(error).partition("\n")[0]
            raise ClusterError(
                f"{self._address}: no scheduler answers there ({why}): start one with 'dask scheduler', or give local; "
                "the address of a scheduler with TLS begins with tls://"
            ) from None

    def _close_client(self) -> None:
        with suppress(*GONE):
            self.client.close(timeout=2)

    def close(self) -> None:
        """Leave the cluster: workers that stay end their processes, and workers of this machine end."""
        if self._local is None:
            with suppress(*GONE):
                self.client.run(worker_side.end_processes, wait=True, on_error="return")
        self._close_client()
        self._close_local()

    def _close_local(self) -> None:
        if self._local is not None:
            self._local.close(GONE)


@contextmanager
def connection(address: Address, say: Callable[[str], None]) -> Iterator[Connection]:
    """A connection, closed in the end.

    Raises:
        ClusterError: Dask distributed is not installed, or there is no scheduler.
    """
    if importlib.util.find_spec("distributed") is None:
        raise ClusterError(
            f"{address}: Dask distributed is not installed: pip install 'pytest-hricdv[cluster]'"
        ) from None
    if address.scheduler and not address.is_encrypted:
        say(UNENCRYPTED.format(address=address))
    with _quiet():
        made = Connection(address, say)
        try:
            yield made
        finally:
            made.close()


@contextmanager
def _quiet() -> Iterator[None]:
    """Silence Dask's log, which repeats our messages at length."""
    log = logging.getLogger("distributed")
    before = log.level
    log.setLevel(logging.CRITICAL + 1)  # above all that it says
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            yield
        finally:
            log.setLevel(before)


def _credentials(address: Address) -> Security:
    """The credentials of Dask's settings. Raises ClusterError if they are needed, and missing or damaged."""
    from distributed.security import Security

    made = Security()
    try:
        context = made.get_connection_args("client")["ssl_context"]
    except OSError as error:
        role = made.get_tls_config_for_role("client")
        files = ", ".join(quote(role[name]) for name in ("ca_file", "cert", "key"))
        raise ClusterError(
            f"{address}: the credentials in Dask's settings, {files}, cannot be read ({error}): expected {CREDENTIALS}"
        ) from None
    if context is None and address.is_encrypted:
        raise ClusterError(f"{address}: there are no credentials in Dask's settings: expected {CREDENTIALS}")
    return made
