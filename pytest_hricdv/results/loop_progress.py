"""How far a loop is that runs tests before there is a journal: a small file in the report folder, while it runs."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path

import msgspec

from pytest_hricdv._base.atomic_file import write_text
from pytest_hricdv._base.contained import inside
from pytest_hricdv._base.input_file import MalformedError, from_json, read_text
from pytest_hricdv._base.record import Count, NotNegative, PlainRecord

NAME = "loop.json"


class LoopProgress(PlainRecord, frozen=True, kw_only=True):
    """The progress of a loop.

    Args:
        began: date and time (UTC, ISO 8601).
        done: its runs.
        most: the number of runs it may do.
        workers: processes that run tests.
        wall_s: how long that took (s).
        sim_s: simulated time of all runs (s).
        verdicts: requirement -> how many runs had which verdict.
        violated: requirement that is not known to fail -> the lines of the shortest test that violates it.
        open: kind of points -> how many no run has hit.
    """

    began: str
    done: Count
    most: Count
    workers: Count
    wall_s: NotNegative
    sim_s: NotNegative
    verdicts: Mapping[str, Mapping[str, Count]]
    violated: Mapping[str, tuple[str, ...]]
    open: Mapping[str, Count]


def tell(folder: Path, progress: LoopProgress) -> None:
    """Write how far a loop is, for those who look. That nobody can read it stops no loop."""
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        write_text(inside(folder, NAME), msgspec.json.encode(progress).decode())


def forget(folder: Path) -> None:
    """The loop has ended."""
    with contextlib.suppress(OSError):
        inside(folder, NAME).unlink(missing_ok=True)


def told(folder: Path) -> LoopProgress | None:
    """The progress of the running loop; None without one."""
    try:
        return from_json(read_text(folder / NAME), LoopProgress)
    except (OSError, MalformedError):
        return None
