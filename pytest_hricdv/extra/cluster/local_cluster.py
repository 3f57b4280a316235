"""Scheduler and workers on this machine, which nobody but this session can talk to."""

from __future__ import annotations

import copy
import logging
import sys
from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING, Any

from pytest_hricdv.extra.cluster.private_folder import UnsafeFolderError, private_folder
from pytest_hricdv.session.remote import ClusterError

if TYPE_CHECKING:
    from distributed import LocalCluster
    from distributed.security import Security

_HERE = "127.0.0.1"
_NO_ROUTES: dict[str, list[str]] = {"distributed.scheduler.http.routes": [], "distributed.worker.http.routes": []}
"""Dask's HTTP servers cannot be left out, and know no credentials: with nothing in them, all they answer is 404."""


class LocalWorkers:
    """A scheduler and workers.

    They listen on loopback only, and take what is encrypted with credentials that are made here, kept in memory and
    forgotten with this object: other users of the machine, and other programs, are refused. Their files are in a
    folder for this user only: Dask's own choice, `/tmp/dask-scratch-space`, may be another user's, and Python looks for
    modules in it.

    Args:
        workers: number of workers.

    Raises:
        ClusterError: there can be no such cluster on this machine.
    """

    def __init__(self, workers: int) -> None:
        self._stack = ExitStack()
        try:
            folder = self._stack.enter_context(private_folder("workers"))
            self._stack.callback(_forget, str(folder))
            self.cluster: LocalCluster = _start_cluster(workers, str(folder), _credentials())
        except UnsafeFolderError as error:
            raise ClusterError(f"local:{workers}: {error}") from None
        except BaseException:
            self._stack.close()
            raise

    def close(self, errors: tuple[type[Exception], ...]) -> None:
        """End them.

        Args:
            errors: of a connection that is gone, which do not matter now.
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


def _credentials() -> Security:
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
