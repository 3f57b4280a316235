"""The connection to a Dask scheduler, which is restored after the scheduler was unavailable."""

from __future__ import annotations

import importlib.util
import logging
import os
import re
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pytest_hricdv._base.message import quote
from pytest_hricdv.extra.cluster import service as worker_side
from pytest_hricdv.extra.cluster.local_cluster import LocalWorkers
from pytest_hricdv.session.remote import ClusterError

if TYPE_CHECKING:
    from distributed import Client
    from distributed.security import Security

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
    """A cluster.

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
    """A connection.

    Args:
        address: of the scheduler; where it says so, scheduler and workers are started on this machine.
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
                "one that has TLS has a tls:// address"
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
