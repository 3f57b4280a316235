"""The progress of a loop that runs tests before there is a journal: a small file in the report folder while it runs."""

from __future__ import annotations

import contextlib
from pathlib import Path

import msgspec

from pytest_hricdv._base.atomic_file import write_text
from pytest_hricdv._base.contained import inside
from pytest_hricdv._base.input_file import MalformedError, from_json, read_text
from pytest_hricdv._base.record import Count, Names, NotNegative, PlainRecord

NAME = "loop.json"


class LoopProgress(PlainRecord, frozen=True, kw_only=True):
    """The progress of a loop.

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
        write_text(inside(folder, NAME), msgspec.json.encode(progress).decode())


def remove_progress(folder: Path) -> None:
    """The loop has ended."""
    with contextlib.suppress(OSError):
        inside(folder, NAME).unlink(missing_ok=True)


def read_progress(folder: Path) -> LoopProgress | None:
    """The progress of the running loop; None without one."""
    try:
        return from_json(read_text(folder / NAME), LoopProgress)
    except (OSError, MalformedError):
        return None
