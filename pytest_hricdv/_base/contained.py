"""Access to files in a folder whose content is not trusted: symbolic links below it are never followed.

A report, a journal or a campaign that comes as an artefact is a folder that somebody else made. A link in it would let
a merge carry a file of this machine along, or write one somewhere else. The folder itself is the user's choice, and may
be reached by links.

Errors are of the kind `OSError`, as are all others of reading and writing: whoever reports these reports them, too.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

_NO_LINK = getattr(os, "O_NOFOLLOW", 0)
"""Windows has no such flag; there, making a link is a right of its own."""
_ADVICE = "a symbolic link, which is not followed here: remove it"


def inside(folder: Path, name: str) -> Path:
    """`folder / name`, where every folder on the way is one; the file itself is not looked at: a rename replaces it.

    Args:
        folder: whose content may be somebody else's.
        name: of a file, relative to the folder, between slashes.

    Raises:
        OSError: a part of the name is a symbolic link, or the name leads out of the folder.
    """
    parts = PurePosixPath(name).parts
    if not parts or parts[0] == "/" or ".." in parts:
        raise OSError(errno.EINVAL, "leads out of its folder", str(folder / name))
    path = folder
    for part in parts[:-1]:
        path = path / part
        _refuse_link(path)
    return path / parts[-1]


def file_inside(folder: Path, name: str) -> Path:
    """The same of a file that is read or changed in place: it is no link, either. Raises as `inside`."""
    path = inside(folder, name)
    _refuse_link(path)
    return path


def files_inside(folder: Path, name: str, suffixes: tuple[str, ...]) -> Iterator[Path]:
    """The files in a folder inside, with these endings, by name; none where there is no such folder.

    Raises:
        OSError: the folder, or a file in it, is a symbolic link.
    """
    for path in sorted(file_inside(folder, name).glob("*")):
        if path.name.endswith(suffixes):
            _refuse_link(path)
            if path.is_file():
                yield path


def open_unlinked(path: Path, flags: int, mode: int = 0o666) -> int:
    """As `os.open`, of a file that is no symbolic link. Raises OSError."""
    try:
        return os.open(path, flags | _NO_LINK, mode)
    except OSError as error:
        if error.errno == errno.ELOOP:
            raise OSError(errno.ELOOP, _ADVICE, str(path)) from None
        raise


def _refuse_link(path: Path) -> None:
    try:
        mode = os.lstat(path).st_mode
    except FileNotFoundError:
        return
    if stat.S_ISLNK(mode):
        raise OSError(errno.ELOOP, _ADVICE, str(path))
