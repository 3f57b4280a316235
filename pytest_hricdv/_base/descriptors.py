"""The session's file descriptors, protected from code under test that closes more than it has opened.

Around each run, `runtime.virtual.outside` calls `keep_open` and `leave_open`; `runtime.virtual.prohibition` refuses to
close those in `OWN`. `ProcessState` restores `StandardDescriptors` after the run.
"""

from __future__ import annotations

import os
from contextlib import suppress

STANDARD = (0, 1, 2)
"""Standard input, output and errors."""

OWN: set[int] = {*STANDARD}
"""The descriptors (numbers) of the session, which code under test must not close."""

_LEFT: dict[int, tuple[int, int]] = {}
"""Descriptor that a run left open -> device and inode of its file. Code under test may close it later."""


def keep_open() -> None:
    """Mark all open descriptors as the session's, except those that runs left open; called before a run."""
    now = _open_files()
    OWN.clear()
    OWN.update(STANDARD, (number for number, file in now.items() if _LEFT.get(number) != file))


def leave_open() -> None:
    """Mark descriptors opened since `keep_open` as not the session's; called after a run."""
    now = _open_files()
    _LEFT.clear()
    _LEFT.update({number: file for number, file in now.items() if number not in OWN})


def _open_files() -> dict[int, tuple[int, int]]:
    found: dict[int, tuple[int, int]] = {}
    with suppress(OSError):  # Windows has no such folder
        for number in map(int, os.listdir("/dev/fd")):
            with suppress(OSError):  # the folder's own, which is closed now
                status = os.fstat(number)
                found[number] = status.st_dev, status.st_ino
    return found


def _is_open(number: int) -> bool:
    try:
        os.fstat(number)
    except OSError:  # the folder's own, which is closed now
        return False
    return True


class StandardDescriptors:
    """A snapshot of standard input, output and errors."""

    def __init__(self) -> None:
        self._copies: dict[int, int] = {}
        for number in STANDARD:
            with suppress(OSError):  # it was closed before
                self._copies[number] = os.dup(number)

    def put_back(self) -> None:
        """Restore the same files."""
        for number, copy in self._copies.items():
            if not _is_open(number) or not os.path.samestat(os.fstat(number), os.fstat(copy)):
                os.dup2(copy, number)
            os.close(copy)
        self._copies.clear()
