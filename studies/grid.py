"""Sessions of a study, one for each suite and seed: those whose reports are missing are run, so it can be resumed."""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from pytest_hricdv._base import atomic_file
from pytest_hricdv.results.codec import REPORT_NAME, load
from pytest_hricdv.results.model import Report
from studies import session
from studies.dependencies import depends

SUITES = ("rl", "by-hand", "bdi-random", "pseudorandom")
WORKERS = 2  # of the cores of the machine that the pages are made on; no report depends on it but for its times
MADE_OF = "made-of.json"
"""Beside a report: the arguments of its session, and what it depended on."""


@dataclass(frozen=True)
class Cell:
    """A session: a suite at a seed, with further options of pytest, and what a study calls it beside the suite."""

    suite: str
    seed: int
    options: tuple[str, ...] = ()
    label: str = ""

    def __str__(self) -> str:
        return f"{self.name} at seed {self.seed}"

    @property
    def name(self) -> str:
        """What a study calls sessions of this kind."""
        return self.label or self.suite

    def folder(self, parent: Path) -> Path:
        """Of its report."""
        return parent / f"{self.name.replace(' ', '-')}-{self.seed}"

    @property
    def arguments(self) -> list[str]:
        """Of pytest."""
        return [f"--hri-suite={self.suite}", f"--hri-seed={self.seed}", *self.options, "-n", str(WORKERS)]


def add_options(parser: argparse.ArgumentParser, seeds: str, suites: tuple[str, ...] = SUITES) -> None:
    """Options that choose the sessions.

    Args:
        seeds: the default.
        suites: those that there are; all are the default.
    """
    chosen = partial(_suites, choices=suites)
    parser.add_argument("--suites", type=chosen, default=suites, metavar="NAME,...", help=f"({','.join(suites)})")
    parser.add_argument("--seeds", type=_seeds, default=_seeds(seeds), metavar="N,N-N,...", help=f"({seeds})")


def _suites(text: str, choices: tuple[str, ...]) -> tuple[str, ...]:
    names = tuple(text.split(","))
    unknown = [name for name in names if name not in choices]
    if unknown:
        raise argparse.ArgumentTypeError(f"{unknown[0]!r}: expected one of {', '.join(choices)}")
    return names


def _seeds(text: str) -> tuple[int, ...]:
    seeds: dict[int, None] = {}
    for part in text.split(","):
        ends = re.fullmatch(r"([0-9]+)(?:-([0-9]+))?", part)
        if ends is None or int(ends[2] or ends[1]) < int(ends[1]):
            raise argparse.ArgumentTypeError(f"{part!r}: expected a seed such as 3, or seeds such as 0-9")
        seeds |= dict.fromkeys(range(int(ends[1]), int(ends[2] or ends[1]) + 1))
    return tuple(seeds)


def cells(suites: Sequence[str], seeds: Sequence[int], options: Sequence[str] = ()) -> list[Cell]:
    """The sessions, seed by seed."""
    return [Cell(suite, seed, tuple(options)) for seed in seeds for suite in suites]


def reports(
    cells: Iterable[Cell], folder: Path, *, again: bool, complete: Callable[[Report], bool] = lambda _: True
) -> Iterator[tuple[Cell, Report | None]]:
    """The report of each session: the one that is there, if it is of the present code, or of a new run.

    Args:
        folder: of the folders of the reports.
        again: run nothing; None where there is no report of the present code.
        complete: whether a report has what the study needs.

    Raises:
        SessionError: a session did not run its tests, its report is not complete, or code changed meanwhile.
        ReportError: a report is damaged.
        DependencyError: a file of the repository is missing.
    """
    dependencies = depends(session.ROOT)
    for cell in cells:
        place = cell.folder(folder)
        made_of = json.dumps({"arguments": cell.arguments, "depends": dependencies}, sort_keys=True, indent=1) + "\n"
        report = _finished(place, made_of)
        if (report is None or not complete(report)) and not again:
            print(f"pytest {' '.join(cell.arguments)} ...", flush=True)
            # First, so that a session that is broken off leaves no report that counts as one of the present code.
            (place / MADE_OF).unlink(missing_ok=True)
            session.run(place, cell.arguments)
            if depends(session.ROOT) != dependencies:
                raise session.SessionError(f"{cell}: code was changed while it ran; start again, with the new code")
            atomic_file.write_text(place / MADE_OF, made_of)
            report = load(place)
            if not complete(report):
                raise session.SessionError(f"{place}: the session did not come to its end; run it by hand to see why")
        yield cell, report if report is not None and complete(report) else None


def _finished(place: Path, made_of: str) -> Report | None:
    """The report in a folder, if it was made of this."""
    try:
        same = (place / MADE_OF).read_text(encoding="utf-8") == made_of
    except OSError:
        return None
    return load(place) if same and (place / REPORT_NAME).is_file() else None
