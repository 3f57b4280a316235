"""Descriptors of the session: code under test may close what it has opened, and none of these."""

from __future__ import annotations

import os
from contextlib import suppress

STANDARD = (0, 1, 2)
"""Standard input, output and errors."""

OWN: set[int] = {*STANDARD}
"""Those that are the session's."""


def keep_open() -> None:
    """All that are open now are the session's; to be called before code under test is imported."""
    OWN.clear()
    OWN.update(STANDARD)
    with suppress(OSError):  # Windows has no such folder
        OWN.update(number for number in map(int, os.listdir("/dev/fd")) if _is_open(number))


def _is_open(number: int) -> bool:
    try:
        os.fstat(number)
    except OSError:  # the folder's own, which is closed now
        return False
    return True


class StandardDescriptors:
    """Standard input, output and errors as they are when this is made."""

    def __init__(self) -> None:
        self._copies: dict[int, int] = {}
        for number in STANDARD:
            with suppress(OSError):  # it was closed before
                self._copies[number] = os.dup(number)

    def put_back(self) -> None:
        """Let them be the same files again."""
        for number, copy in self._copies.items():
            if not _is_open(number) or not os.path.samestat(os.fstat(number), os.fstat(copy)):
                os.dup2(copy, number)
            os.close(copy)
        self._copies.clear()
