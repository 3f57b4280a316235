"""`private_folder`: a folder for workers' files in which no other user of the machine can add or change a file.

`LocalWorkers` and `code_archive` use it; `require_safe` checks an existing folder.
"""

from __future__ import annotations

import os
import shutil
import stat
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

_ALL_IDS = "4294967295"
"""Number of user ids in the id map of a process outside user namespaces (`man user_namespaces`)."""


class UnsafeFolderError(OSError):
    """Another user can replace files in a folder; the message says which folder, why, and what to do."""


@contextmanager
def private_folder(purpose: str, parent: Path | None = None) -> Iterator[Path]:
    """A new folder with an unpredictable name, for this user only; it is removed at the end.

    Args:
        purpose: a word of its name.
        parent: where it is made; None: the system's folder for temporary files.

    Raises:
        UnsafeFolderError: another user can replace files in the parent.
        OSError: no folder can be made there.
    """
    place = (parent or Path(tempfile.gettempdir())).resolve()
    require_safe(place)
    made = Path(tempfile.mkdtemp(prefix=f"hricdv-{purpose}-", dir=place))  # 0700, and an error where it exists
    try:
        yield made
    finally:
        shutil.rmtree(made, ignore_errors=True)


def require_safe(folder: Path) -> None:
    """Raise UnsafeFolderError if another user can replace a folder, or an entry of ours in it.

    The rule is that of sshd: from the root down, each folder belongs to root or to this user, and is sticky, as `/tmp`,
    if others may write to it. Links on the way are followed, and their targets checked.
    Nothing is checked on Windows, where the folder for temporary files is the user's own.
    """
    if not hasattr(os, "getuid"):
        return
    place = folder.resolve()
    for path in (place, *place.parents):
        why = _why_unsafe(path.lstat())
        if why:
            raise UnsafeFolderError(
                f"{path}: {why}, so that another user can exchange files below it: set TMPDIR (of a worker, "
                "--local-directory) to a folder of your own, as mkdir -m 700 makes it"
            )


def _why_unsafe(status: os.stat_result) -> str:
    if status.st_uid not in _safe_owners():
        return f"it belongs to user {status.st_uid}"
    own_group = status.st_gid == os.getuid()  # the group that many systems make for each user, with the same number
    writable = status.st_mode & stat.S_IWOTH or (status.st_mode & stat.S_IWGRP and not own_group)
    if writable and not status.st_mode & stat.S_ISVTX:
        return f"others may write to it (mode {stat.S_IMODE(status.st_mode):04o}, not sticky)"
    return ""


@cache
def _safe_owners() -> frozenset[int]:
    """User ids whose folders cannot hurt: our own, root, and in a user namespace the one that stands for others."""
    own = {os.getuid(), 0}
    try:
        if _ALL_IDS not in Path("/proc/self/uid_map").read_text(encoding="ascii").split():
            own.add(int(Path("/proc/sys/kernel/overflowuid").read_text(encoding="ascii")))
    except (OSError, ValueError):  # not Linux: no such namespaces
        pass
    return frozenset(own)
