"""Which cluster: `local`, `local:2`, or the address of a scheduler, as `tcp://host:8786`."""

from __future__ import annotations

import os
import re
from dataclasses import dataclass

from pytest_hricdv._base.message import quoted
from pytest_hricdv.session.remote import ClusterError

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
        """What an option says. Raises ClusterError."""
        local = _LOCAL.fullmatch(text)
        if local is not None:
            workers = int(local[1]) if local[1] else os.cpu_count() or 1
            if workers < 1:
                raise ClusterError(f"{quoted(text)}: expected at least one worker, as in local:2")
            return cls(workers=workers)
        if _SCHEDULER.fullmatch(text):
            return cls(scheduler=text)
        raise ClusterError(f"{quoted(text)}: expected local, local:WORKERS or a scheduler's tcp://HOST:PORT")

    @property
    def is_encrypted(self) -> bool:
        """Whether both ends show who they are, and nobody else can read along: of workers on this machine, always."""
        return not self.scheduler or self.scheduler.startswith(("tls://", "wss://"))

    def __str__(self) -> str:
        return self.scheduler or f"local:{self.workers}"
