"""Search the schedules of the robots and of their twins; print at how many seeds each race is found, and its words.

    python -m studies.races [--seeds 20] [--runs 100] [--twin-runs 300] [--robots NAME,...] [--results DIR]

Each session is one process. What is in the folder of results already is not run again.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

from studies import session
from studies.races.catalogue import RACES, Race

TESTS = 10
"""Tests of each suite."""


def main() -> None:
    """Search and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=20, metavar="N")
    parser.add_argument("--runs", type=int, default=100, metavar="N", help="runs with other schedules of each robot")
    parser.add_argument("--twin-runs", type=int, default=300, metavar="N", help="the same of each twin")
    parser.add_argument("--robots", default=",".join(race.name for race in RACES), metavar="NAME,...")
    parser.add_argument("--results", type=Path, default=Path("races-study"), metavar="DIR")
    options = parser.parse_args()
    chosen = [race for race in RACES if race.name in options.robots.split(",")]
    print(f"{'robot':<28}{'found':>10}{'median run':>12}{'late only':>12}{'twin fails':>12}{'twin late':>12}")
    for race in chosen:
        print(row(race, options), flush=True)


def row(race: Race, options: argparse.Namespace) -> str:
    """A line of the table, and below it the words for one of the races that were found."""
    seeds = range(options.seeds)
    found = [search(race, options.results, seed, options.runs) for seed in seeds]
    twins = [search(race, options.results, seed, options.twin_runs, repaired=True) for seed in seeds]
    firsts = [min(race["found_after"] for race in races if race["is_counted"]) for races in found if fails(races)]
    late, twins_late = (sum(bool(races) and not fails(races) for races in each) for each in (found, twins))
    number = f"{median(firsts):g}" if firsts else ""
    of = f" of {options.seeds}"
    name = race.name + " (held out)" * race.is_held_out
    counts = (f"{len(firsts)}{of}", number, f"{late}{of}", f"{sum(map(fails, twins))}{of}", f"{twins_late}{of}")
    words = dict.fromkeys(f"\n    {race['kind']}: {race['words']}" for races in (*found, *twins) for race in races)
    return f"{name:<28}{counts[0]:>10}{counts[1]:>12}{counts[2]:>12}{counts[3]:>12}{counts[4]:>12}" + "".join(words)


def fails(races: Sequence[dict[str, Any]]) -> bool:
    """Whether a session fails for what it found: what is only late, it lists."""
    return any(race["is_counted"] for race in races)


def search(
    race: Race, folder: Path, seed: int, runs: int, *, repaired: bool = False, tests: int = TESTS
) -> list[dict[str, Any]]:
    """The races found in a session, with `found_after`, `kind`, `is_counted` and `words`; kept in the folder.

    Raises:
        SessionError: the suite does not pass under the usual schedule, or the session ended before its end.
    """
    name = f"{race.name}-{'repaired' if repaired else 'robot'}-seed-{seed}-runs-{runs}"
    project = folder.resolve() / name
    kept = project.with_suffix(".json")
    if not kept.is_file():
        race.write(project, repaired=repaired)
        report = session.run(project / "report", arguments(seed, runs, tests), project).report
        failed = [test["id"] for test in report["tests"] if test["outcome"] != "passed"]
        if failed:
            raise session.SessionError(f"{name} fails under the usual schedule: {', '.join(failed)}")
        kept.write_text(json.dumps(report["schedules"], indent=1), encoding="utf-8")
    races: list[dict[str, Any]] = json.loads(kept.read_text(encoding="utf-8")).get("races", [])
    return races


def arguments(seed: int, runs: int, tests: int) -> Sequence[str]:
    """The options of a session."""
    suite = ("--hri-suite=pseudorandom", f"--hri-tests={tests}", f"--hri-seed={seed}")
    return (*suite, f"--hri-schedules={runs}", "--hri-audit=off", "--hri-no-cov")


if __name__ == "__main__":
    main()
