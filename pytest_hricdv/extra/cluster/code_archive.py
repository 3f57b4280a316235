"""The project as one archive, for workers that do not have it."""

from __future__ import annotations

import io
import os
import stat
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path, PurePosixPath

from pytest_hricdv._base import project_files
from pytest_hricdv._base.message import quoted
from pytest_hricdv.extra.cluster.address import ClusterError
from pytest_hricdv.extra.cluster.private_folder import private_folder

MOST_BYTES = 100_000_000
"""A project of code and models has less; more is a data set, or a folder of results."""

_EPOCH = (1980, 1, 1, 0, 0, 0)
"""The first date that ZIP knows, of all files in an archive: the same files give the same archive."""


_REPORT = "report.json"


class ArchiveError(Exception):
    """What was sent cannot be unpacked; the text says why."""


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


def digest(archive: bytes) -> str:
    """SHA-256 of an archive, in hexadecimal digits."""
    return sha256(archive).hexdigest()


@contextmanager
def unpacked(archive: bytes, parent: Path | None = None) -> Iterator[Path]:
    """A new folder with the files of an archive and nothing else, for this user only; in the end it is removed.

    New for each process: what another user, or code under test, has put anywhere before is not in it.

    Args:
        parent: the folder that it is made in; None: that for temporary files.

    Raises:
        ArchiveError: it is damaged, or not as `pack` makes them.
        OSError: it cannot be written, or others could change it where files are to be written.
    """
    with private_folder("code", parent) as private:
        # pytest looks for settings in all folders above, and would take those that somebody has left in /tmp.
        (private / "pytest.ini").write_text("[pytest]\n", encoding="ascii")
        folder = private / "project"
        folder.mkdir()
        try:
            with zipfile.ZipFile(io.BytesIO(archive)) as packed:
                _unpack(packed, folder)
        except (zipfile.BadZipFile, zlib.error, RuntimeError, NotImplementedError) as error:
            raise ArchiveError(f"the project that was sent is damaged: {error}") from None
        yield folder


def _unpack(packed: zipfile.ZipFile, folder: Path) -> None:
    entries = packed.infolist()
    size = sum(entry.file_size for entry in entries)
    if size > MOST_BYTES:
        raise ArchiveError(f"the project that was sent has {size:,} bytes, expected at most {MOST_BYTES:,}")
    for entry in entries:
        path = folder / _relative(entry)
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("xb") as file:  # x: a name that is there already, or a link of that name, is an error
            file.write(packed.read(entry))


def _relative(entry: zipfile.ZipInfo) -> PurePosixPath:
    """Where a file belongs, within the project. Raises ArchiveError for a place outside, a link or a folder."""
    path = PurePosixPath(entry.filename)
    # Colons are drives and streams on Windows; what Windows takes for a separator is none elsewhere.
    is_inside = path.parts and not path.is_absolute() and not {"..", "."} & {*entry.filename.split("/")}
    is_plain = os.name != "nt" or not {":", "\\"} & {*entry.orig_filename}
    is_file = stat.S_IFMT(entry.external_attr >> 16) in (0, stat.S_IFREG) and not entry.is_dir()
    if not (is_inside and is_plain and is_file) or "\0" in entry.orig_filename:
        raise ArchiveError(
            f"the project that was sent has {quoted(entry.orig_filename)}: expected files below its folder"
        )
    return path
