"""Files in a report folder while a session runs: `JournalKeeper`'s `FolderLock`, and the closing loop's progress."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

import msgspec

from pytest_hricdv._base.atomic_file import write_text
from pytest_hricdv._base.contained import inside, open_unlinked
from pytest_hricdv._base.input_file import MalformedError, from_json, read_text
from pytest_hricdv._base.record import Count, Names, NotNegative, PlainRecord

PROGRESS_FILE = "loop.json"


class LoopProgress(PlainRecord, frozen=True, kw_only=True):
    """The progress of a closing loop, which `hricdv report live` shows.

    Args:
        done: number of its runs.
        most: largest number of runs.
        workers: processes that run tests.
        wall_s: duration so far (s).
        verdicts: requirement, and how many runs passed it, failed it and did not check it.
        causes: violations that are not known, a sentence each.
        open: how many points of each kind no run has hit, in words.
    """

    done: Count
    most: Count
    workers: Count
    wall_s: NotNegative
    verdicts: tuple[tuple[str, Count, Count, Count], ...]
    causes: Names
    open: Names


def write_progress(folder: Path, progress: LoopProgress) -> None:
    """Write the progress for viewers. A folder that cannot be written does not stop the loop."""
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        write_text(inside(folder, PROGRESS_FILE), msgspec.json.encode(progress).decode())


def remove_progress(folder: Path) -> None:
    """Remove the progress of a loop that has ended."""
    with contextlib.suppress(OSError):
        inside(folder, PROGRESS_FILE).unlink(missing_ok=True)


def read_progress(folder: Path) -> LoopProgress | None:
    """The progress of the running loop; None without one."""
    try:
        return from_json(read_text(folder / PROGRESS_FILE), LoopProgress)
    except (OSError, MalformedError):
        return None


try:
    import fcntl
except ImportError:  # Windows: nothing is locked there
    fcntl = None  # type: ignore[assignment]

NAME = ".lock"


class LockedError(Exception):
    """Another process holds the lock; the message names it."""


class FolderLock:
    """A lock on a folder, held from construction to `release`.

    It is a POSIX lock, which the kernel releases when the process dies. Unlike a BSD lock, forked children do not
    inherit it, so a child that survives its session keeps nobody out. File systems without locks are not locked.

    Args:
        folder: an existing folder.
        name: the name of the lock file.

    Raises:
        LockedError: another process holds it.
        OSError: the lock file cannot be written.
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
        """Release the lock."""
        os.close(self._file)
