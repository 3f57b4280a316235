"""Where workers find the project of a session: at the same path as here, or in what they are sent."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from pytest_hricdv._base import project_files
from pytest_hricdv.extra.cluster import code_archive
from pytest_hricdv.extra.cluster.service import Service


@dataclass(frozen=True)
class WorkerProject:
    """The project, as processes of workers find it.

    Args:
        directory: where they start; with an archive, relative to the folder with its files.
        root: the project's folder, relative to that.
        sources: its files that runs depend on, name -> hash: compared before anything of it is imported.
        archive: with all of its files; empty where workers have them.
    """

    directory: str
    root: str
    sources: Mapping[str, str] = field(default_factory=dict)
    archive: bytes = b""

    @property
    def archive_sha256(self) -> str:
        """Of the archive; empty where there is none."""
        return code_archive.digest(self.archive) if self.archive else ""

    @property
    def arguments(self) -> tuple[str, ...]:
        """Of pytest, before all others: in what was sent, no settings of folders above are looked for."""
        return (f"--rootdir={self.root}",) if self.archive else ()

    def service(self, module: str, job: bytes, project: Mapping[str, str], silent_s: float) -> Service:
        """What workers are asked; see `Service`."""
        return Service(
            module, job, self.directory, project, silent_s, self.root, self.sources, archive_sha256=self.archive_sha256
        )


def worker_project(root: Path, here: Path, *, send: bool, state: Path | None = None) -> WorkerProject:
    """The project below a folder, of a session that was started somewhere.

    Args:
        root: its folder.
        here: where the session was started; where it is sent, in that folder.
        send: whether workers are sent it.
        state: the file of a campaign, which is not sent.

    Raises:
        ClusterError: it is too large to be sent.
    """
    return WorkerProject(
        directory=str(here.relative_to(root)) if send else str(here),
        root=Path(os.path.relpath(root, here)).as_posix(),
        sources=project_files.hashes(root),
        archive=code_archive.pack(root, state) if send else b"",
    )


def project_of(config: pytest.Config, *, send: bool) -> WorkerProject:
    """Of a session. Raises as `worker_project`."""
    return worker_project(Path(config.rootpath), config.invocation_params.dir, send=send)
