"""Access to files in a folder whose content is not trusted: symbolic links below it are never followed.

A report, a journal or a campaign that comes as an artefact is a folder that somebody else made. A link in it would let
a merge copy a file of this machine, or write one elsewhere. So all modules that use such folders get paths from
`inside`, to write, and `file_inside`, to read. The path of the folder itself may contain links. Errors are
`OSError`s, like all errors of reading and writing, so the same handlers report them.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from pathlib import Path, PurePosixPath

_NO_LINK = getattr(os, "O_NOFOLLOW", 0)
"""Flag of `os.open` to refuse links; Windows has no such flag, but making a link needs a privilege there."""
_ADVICE = "a symbolic link, which is not followed here: remove it"


def inside(folder: Path, name: str) -> Path:
    """`folder / name`, if no folder on the way is a link. The file itself is not checked: a rename replaces it.

    Args:
        folder: its content is not trusted.
        name: the name of a file, relative to the folder, between slashes.

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
    """Like `inside`, for a file that is read or changed in place and must not be a link. Raises the same errors."""
    path = inside(folder, name)
    _refuse_link(path)
    return path


def files_inside(folder: Path, name: str, suffixes: tuple[str, ...]) -> Iterator[Path]:
    """The files with these suffixes in an inner folder, by name; none if there is no such folder.

    Raises:
        OSError: the folder, or a file in it, is a symbolic link.
    """
    for path in sorted(file_inside(folder, name).glob("*")):
        if path.name.endswith(suffixes):
            _refuse_link(path)
            if path.is_file():
                yield path


def open_unlinked(path: Path, flags: int, mode: int = 0o666) -> int:
    """Like `os.open`, for a file that is not a symbolic link. Raises OSError."""
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
