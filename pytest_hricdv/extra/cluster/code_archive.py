"""The project as one archive, for workers that do not have it."""

from __future__ import annotations

import io
import os
import shutil
import tempfile
import zipfile
from hashlib import sha256
from pathlib import Path

from pytest_hricdv._base import project_files
from pytest_hricdv.extra.cluster.address import ClusterError

MOST_BYTES = 100_000_000
"""A project of code and models has less; more is a data set, or a folder of results."""

_EPOCH = (1980, 1, 1, 0, 0, 0)
"""The first date that ZIP knows, of all files in an archive: the same files give the same archive."""


_REPORT = "report.json"


def pack(root: Path, state: Path | None = None) -> bytes:
    """All files of a project as a ZIP archive, but for hidden folders, environments, reports and a campaign's state.

    Args:
        root: the project's folder.
        state: the file that keeps the campaign, which with those beside it (`-wal`) is no part of the project.

    Raises:
        ClusterError: they are too many to be sent.
    """
    packed, size = io.BytesIO(), 0
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in _sent(root, state):
            size += path.stat().st_size
            if size > MOST_BYTES:
                raise ClusterError(
                    f"--send-code: {root} has more than {MOST_BYTES:,} bytes, {path.relative_to(root)} included: "
                    "install the project where the workers are, or keep results in a hidden folder (.NAME)"
                )
            entry = zipfile.ZipInfo(path.relative_to(root).as_posix(), _EPOCH)
            archive.writestr(entry, path.read_bytes(), zipfile.ZIP_DEFLATED)
    return packed.getvalue()


def _sent(root: Path, state: Path | None) -> list[Path]:
    files = list(project_files.files(root))
    reports = {path.parent for path in files if path.name == _REPORT}
    kept = [path for path in files if not reports.intersection(path.parents)]
    if state is None:
        return kept
    return [path for path in kept if path.parent != state.parent or not path.name.startswith(state.name)]


def unpacked(archive: bytes) -> Path:
    """The folder with the files of an archive, unpacked at the first use on this machine."""
    folder = Path(tempfile.gettempdir(), f"hricdv-code-{os.getuid() if hasattr(os, 'getuid') else ''}-{_name(archive)}")
    if folder.is_dir():
        return folder
    made = Path(tempfile.mkdtemp(prefix=f"{folder.name}-", dir=folder.parent))
    try:
        with zipfile.ZipFile(io.BytesIO(archive)) as packed:
            packed.extractall(made)
        made.rename(folder)  # at once: nobody finds half of it
    except OSError:
        if not folder.is_dir():  # otherwise another worker was faster
            raise
        shutil.rmtree(made, ignore_errors=True)
    return folder


def _name(archive: bytes) -> str:
    return sha256(archive).hexdigest()[:16]
