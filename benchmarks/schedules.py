"""Cost of runs with schedules, as a ratio to the same tests run without: processor time, forks included.

    python -m benchmarks.schedules [--runs N] [--projects NAME,...]

In a session with `--hri-schedules=N`, each run is followed by one of its test without a schedule, so that what else the
machine does meets both. The ratio is that of the medians.
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage
from statistics import median

from pytest_hricdv.extra.schedules.schedule_run import ScheduleRun, ScheduleWorker
from pytest_hricdv.generate.concrete import ConcreteTest
from studies.localization.projects import HELD_OUT, PROJECTS, Project
from studies.localization.sessions import prepared, ran
from studies.races.catalogue import RACES, Race
from studies.session import machine

WorkerRun = Callable[[ScheduleWorker, ConcreteTest], ScheduleRun | None]

RUN = ScheduleWorker.run

COSTS = "schedule-costs.json"
"""In a project's folder: processor time (s) of each run, with and without a schedule."""

SMALL = "emergency_stop"
"""A robot of `studies.races`: runs of some milliseconds."""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--runs", type=int, default=60, metavar="N", help="with schedules, of each project (default 60)"
    )
    parser.add_argument("--projects", default=f"{SMALL},coffee,vacuum,home_care,table", metavar="NAME,...")
    options = parser.parse_args()
    print(machine())
    for project in (*map(_robot, RACES), *PROJECTS, *HELD_OUT):
        if project.name in options.projects.split(","):
            with tempfile.TemporaryDirectory() as folder:
                print(f"{project.name:16} {_cost(project, Path(folder) / project.name, options.runs)}", flush=True)


def _robot(race: Race) -> Project:
    return Project(
        race.name,
        ("robot",),
        ("--hri-suite=pseudorandom", "--hri-tests=10"),
        lambda folder: race.write(folder, repaired=True),
    )


def _cost(project: Project, folder: Path, runs: int) -> str:
    prepared(project, folder)
    costs = folder / COSTS
    ScheduleWorker.run = _timed(costs)  # type: ignore[method-assign, assignment]
    ran(project, folder, None, (f"--hri-schedules={runs}",))
    with_s, without_s = zip(*json.loads(costs.read_text(encoding="utf-8")), strict=True)
    ratio = median(with_s) / median(without_s)
    medians = f"medians {median(with_s) * 1000:.1f} and {median(without_s) * 1000:.1f} ms"
    return f"{ratio:.2f} times, {medians} of {len(with_s)} runs each"


def _timed(costs: Path) -> WorkerRun:

    spent_s: list[tuple[float, float]] = []

    def timed(worker: ScheduleWorker, test: ConcreteTest) -> ScheduleRun | None:
        began_s = _spent_s(worker)
        ran = RUN(worker, test)
        between_s = _spent_s(worker)
        worker.rerunner.run(replace(test, schedule=()))
        if test.schedule:
            spent_s.append((between_s - began_s, _spent_s(worker) - between_s))
            costs.write_text(json.dumps(spent_s), encoding="utf-8")
        return ran

    return timed


def _spent_s(worker: ScheduleWorker) -> float:
    """Processor time (s) of this process, of those that have ended, and of the worker's."""
    ended = sum(usage.ru_utime + usage.ru_stime for usage in map(getrusage, (RUSAGE_SELF, RUSAGE_CHILDREN)))
    return ended + (time.clock_gettime((~worker.pid << 3) | 2) if worker.pid is not None else 0.0)


if __name__ == "__main__":
    main()
