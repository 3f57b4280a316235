"""Locates the project of a session on a worker: at the same path as here, or in the archive that it is sent."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pytest_hricdv._base import project_files
from pytest_hricdv.extra.cluster import code_archive
from pytest_hricdv.session.remote import Service


@dataclass(frozen=True)
class WorkerProject:
    """The project, as processes of workers find it.

    Args:
        directory: where they start; with an archive, relative to the folder with its files.
        root: the project's folder, relative to that.
        sources: its files that runs depend on, name -> hash: compared before anything of it is imported.
        archive: with all of its files; empty where workers have them.
        left_out: names of sources that are not sent.
    """

    directory: str
    root: str
    sources: Mapping[str, str] = field(default_factory=dict)
    archive: bytes = b""
    left_out: frozenset[str] = frozenset()

    @property
    def archive_sha256(self) -> str:
        """The hash of the archive; empty without one."""
        return code_archive.digest(self.archive) if self.archive else ""

    @property
    def arguments(self) -> tuple[str, ...]:
        """The first arguments of pytest: it must not look for settings above the folder that was sent."""
        return (f"--rootdir={self.root}",) if self.archive else ()

    def service(self, module: str, job: bytes, project: Mapping[str, str], silent_s: float) -> Service:
        """The service of the workers; see `Service`."""
        there = {name: text for name, text in project.items() if name not in self.left_out}
        return Service(
            module,
            job,
            self.directory,
            there,
            silent_s,
            self.root,
            self.sources,
            archive=self.archive,
            archive_sha256=self.archive_sha256,
        )


def worker_project(
    root: Path, here: Path, *, send: bool, state: Path | None = None, hidden: Sequence[str] = ()
) -> WorkerProject:
    """The project below a folder, of a session that was started somewhere.

    Args:
        root: its folder.
        here: where the session was started; where it is sent, in that folder.
        send: whether workers are sent it.
        state: the file of a campaign, which is not sent.
        hidden: patterns of hidden files that are sent.

    Raises:
        ClusterError: it cannot be sent; see `code_archive.files_to_send`.
    """
    way_up, sources = Path(os.path.relpath(root, here)).as_posix(), project_files.hashes(root)
    if not send:
        return WorkerProject(str(here), way_up, sources)
    files = code_archive.files_to_send(root, state, hidden)
    left_out = sources.keys() - {path.relative_to(root).as_posix() for path in files}
    return WorkerProject(
        str(here.relative_to(root)),
        way_up,
        {name: text for name, text in sources.items() if name not in left_out},
        code_archive.pack(root, files),
        frozenset(left_out),
    )
