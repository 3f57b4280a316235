"""The lock of a report folder: held by the session that writes into it, until its process ends."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from pytest_hricdv._base.contained import open_unlinked

try:
    import fcntl
except ImportError:  # Windows: nothing is locked there
    fcntl = None  # type: ignore[assignment]

NAME = ".lock"


class LockedError(Exception):
    """Another process holds the lock; the message names it."""


class FolderLock:
    """Held from its making to `release`.

    A lock of POSIX, which the kernel takes back when the process dies. Forked children do not have it, as they would
    one of BSD: a child that survives its session keeps nobody out. File systems without locks are not locked.

    Args:
        folder: it exists.
        name: of the file of the lock.

    Raises:
        LockedError: another process holds it.
        OSError: the file of the lock cannot be written.
    """

    def __init__(self, folder: Path, name: str = NAME) -> None:
        self._file = open_unlinked(folder / name, os.O_RDWR | os.O_CREAT)
        try:
            self._lock()
        except BaseException:
            os.close(self._file)
            raise

    def _lock(self) -> None:
        if fcntl is None:
            return
        try:
            fcntl.lockf(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except (BlockingIOError, PermissionError):  # which of them depends on the system
            holder = os.pread(self._file, 20, 0).decode("ascii", "replace").strip()
            raise LockedError(f"process {holder}") from None
        except OSError:
            return
        with contextlib.suppress(OSError):
            os.ftruncate(self._file, 0)
            os.pwrite(self._file, b"%d\n" % os.getpid(), 0)

    def release(self) -> None:
        """Let others in."""
        os.close(self._file)
