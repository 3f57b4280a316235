"""The project as one archive, for workers of a cluster that do not have it: `pack` makes it, `unpack` unpacks it.

`worker_project`, called by `DaskCluster`, says what workers get; `service` unpacks it there. It is sent with
`--hri-send-code`, or `--send-code` of a campaign. Otherwise, workers have the project at the same path.
"""

from __future__ import annotations

import io
import os
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path

from pytest_hricdv._base import project_files
from pytest_hricdv._base.message import quote
from pytest_hricdv.extra.cluster.private_folder import private_folder
from pytest_hricdv.session.remote import ClusterError, Service

MAX_BYTES = 100_000_000
"""Maximum size (bytes) of the files: code and models have less; more is a data set, or a folder of results."""

_EPOCH = (1980, 1, 1, 0, 0, 0)
"""The date of all files in an archive, the first that ZIP knows; so the same files give the same archive."""

_REPORT = "report.json"
_SETTINGS = (".pytest.ini", ".pytest.toml")
"""Hidden files in which pytest looks for settings."""


def files_to_send(root: Path, state: Path | None = None, hidden: Sequence[str] = ()) -> list[Path]:
    """The files of a project that workers need.

    Not hidden files, which keep what is nobody else's (`.env`, `.netrc`), hidden folders, environments, reports, and a
    campaign's state. A symbolic link is as good as the file that it leads to, if that is sent itself.

    Args:
        state: the file that keeps the campaign, which, like those next to it (`-wal`), is not part of the project.
        hidden: patterns of hidden files that are sent nevertheless, as `pathlib` matches them: `.env`, `arm/.*.toml`.

    Raises:
        ClusterError: a link leads to what is not sent, or no hidden file has such a name.
    """
    files = list(project_files.files(root))
    reports = {path.parent for path in files if path.name == _REPORT}
    kept = [path for path in files if not reports.intersection(path.parents)]
    if state is not None:
        kept = [path for path in kept if path.parent != state.parent or not path.name.startswith(state.name)]
    secret = {path for path in kept if path.name.startswith(".") and path not in _settings(root)}
    for pattern in hidden:
        matching = {path for path in secret if path.relative_to(root).match(pattern)}
        if not matching:
            raise ClusterError(f"send-hidden: {quote(pattern)}: {root} has no hidden file of this name left to send")
        secret -= matching
    sent = [path for path in kept if path not in secret]
    _require_inside(root, sent)
    return sent


def _settings(root: Path) -> tuple[Path, ...]:
    return tuple(root / name for name in _SETTINGS)


def _require_inside(root: Path, sent: Sequence[Path]) -> None:
    """Raise ClusterError for a link to something that is not sent."""
    real = {path.resolve() for path in sent if not path.is_symlink()}
    for path in sent:
        target = path.resolve()
        if path.is_symlink() and target not in real:
            raise ClusterError(_leads_away(root, path, target, "put a copy of the file in its place"))
    for path in project_files.folder_links(root):
        target = path.resolve()
        if not target.is_relative_to(root.resolve()):
            raise ClusterError(_leads_away(root, path, target, "put a copy of the folder in its place"))


def _leads_away(root: Path, link: Path, target: Path, hint: str) -> str:
    return (
        f"--send-code: {quote(str(link.relative_to(root)))} in {root} is a symbolic link to {quote(str(target))}, "
        f"which is not sent: {hint}, or, if no run needs it, keep it in a hidden folder (.NAME)"
    )


def pack(root: Path, files: Iterable[Path]) -> bytes:
    """Files of a project as a ZIP archive.

    Args:
        files: the files in it, as `files_to_send` gives them.

    Raises:
        ClusterError: they are too many to be sent.
    """
    packed, size = io.BytesIO(), 0
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in files:
            size += path.stat().st_size
            if size > MAX_BYTES:
                raise ClusterError(
                    f"--send-code: {root} has more than {MAX_BYTES:,} bytes, {path.relative_to(root)} included: "
                    "install the project where the workers are, or keep results in a hidden folder (.NAME)"
                )
            entry = zipfile.ZipInfo(path.relative_to(root).as_posix(), _EPOCH)
            archive.writestr(entry, path.read_bytes(), zipfile.ZIP_DEFLATED)
    return packed.getvalue()


@contextmanager
def unpack(archive: bytes, parent: Path | None = None) -> Iterator[Path]:
    """A new folder with the files of an archive and nothing else, for this user only; in the end it is removed.

    New for each process: what another user, or code under test, has put anywhere before is not in it. What is in the
    archive is not checked: whoever can send one runs code here anyway.

    Args:
        archive: as `pack` makes it.
        parent: the folder that it is made in; None: that for temporary files.

    Raises:
        OSError: it cannot be written, or others could change it where files are to be written.
    """
    with private_folder("code", parent) as private:
        # pytest looks for settings in all folders above, and would take those that somebody has left in /tmp.
        (private / "pytest.ini").write_text("[pytest]\n", encoding="ascii")
        with zipfile.ZipFile(io.BytesIO(archive)) as packed:
            packed.extractall(private / "project")
        yield private / "project"


@dataclass(frozen=True)
class WorkerProject:
    """The project, as processes of workers find it.

    Args:
        directory: where they start; with an archive, relative to the folder with its files.
        root: the project's folder, relative to that.
        sources: its files that runs depend on, name -> hash: compared before anything of it is imported.
        archive: the archive of all its files; empty if workers have them.
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
        return sha256(self.archive).hexdigest() if self.archive else ""

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
    files = files_to_send(root, state, hidden)
    left_out = sources.keys() - {path.relative_to(root).as_posix() for path in files}
    return WorkerProject(
        str(here.relative_to(root)),
        way_up,
        {name: text for name, text in sources.items() if name not in left_out},
        pack(root, files),
        frozenset(left_out),
    )
