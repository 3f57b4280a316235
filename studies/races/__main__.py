"""Search the schedules of the robots and of their twins; print at how many seeds each race is found, and its words.

    python -m studies.races [--seeds N] [--twin-seeds N] [--plain-seeds N] [--robots NAME,...] [--results FILE]
    python -m studies.races --page    # the tables of the page, of what was run so far

A search ends with the first race that fails its session. It is repeated with plain pseudorandom schedules: holds at any
statement that a test executes. What is in the file of results already is not run again.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

from pytest_hricdv.extra.schedules import post_session, search
from pytest_hricdv.session.feature import FeatureSession
from studies import session
from studies.localization.projects import Project
from studies.localization.sessions import prepared, ran
from studies.page import replace_figures, table
from studies.races.catalogue import ANCHORS, RACES, Race

TESTS = 10
"""Tests of each suite."""

PAGE = Path(__file__).parents[2] / "docs" / "studies" / "races.md"
COMMAND = "python -m studies.races --page"

RESULTS = Path(__file__).with_name("results.json")

SEARCH_SCHEDULES = post_session.search_schedules

Races = list[dict[str, Any]]
"""The races that a session found, with `found_after`, `failure_kind`, `is_counted` and `words`."""


def main() -> None:
    """Search and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seeds", type=int, default=20, metavar="N")
    parser.add_argument("--runs", type=int, default=100, metavar="N", help="runs with other schedules of each robot")
    parser.add_argument("--twin-runs", type=int, default=300, metavar="N", help="the same of each twin")
    parser.add_argument("--twin-seeds", type=int, default=20, metavar="N")
    parser.add_argument("--plain-seeds", type=int, default=20, metavar="N", help="for pseudorandom schedules")
    every = (*RACES, *ANCHORS)
    parser.add_argument("--robots", default=",".join(race.name for race in every), metavar="NAME,...")
    parser.add_argument("--results", type=Path, default=RESULTS, metavar="FILE")
    parser.add_argument("--page", action="store_true", help="write the tables of stored results to the page")
    options = parser.parse_args()
    if options.page:
        replace_figures(PAGE, COMMAND, tables(json.loads(options.results.read_text(encoding="utf-8"))))
        return
    print(f"{'robot':<30}{'found':>10}{'median':>8}{'last':>6}{'late only':>11}{'plain':>10}{'median':>8}{'twin':>9}")
    for race in every:
        if race.name in options.robots.split(","):
            print(row(race, options), flush=True)


def tables(results: Mapping[str, Races]) -> str:
    """The tables of the page: planted races, then those that others publish."""
    head = ("robot", "found", "median run", "last run", "found by plain schedules", "twins that fail")
    planted, anchors = (table(head, map(partial(_cells, results), races)) for races in (RACES, ANCHORS))
    return f"### Planted races\n\n{planted}\n\n### Races that others publish\n\n{anchors}"


def _cells(results: Mapping[str, Races], race: Race) -> tuple[str, ...]:
    found, plain, twins = (
        [races for key, races in results.items() if key.split()[:2] == [race.name, kind]]
        for kind in ("robot", "plain", "repaired")
    )
    firsts = sorted(map(first, filter(fails, found)))
    runs = (f"{median(firsts):g}", str(firsts[-1])) if firsts else ("-", "-")
    others = tuple(f"{sum(map(fails, races))} of {len(races)}" if races else "-" for races in (plain, twins))
    return f"{race.name}{' (held out)' * race.is_held_out}", f"{len(firsts)} of {len(found)}", *runs, *others


def row(race: Race, options: argparse.Namespace) -> str:
    """A line of the table, and below it the words for the races that were found."""
    of = f" of {options.seeds}"
    found = [kept(race, options.results, seed, options.runs) for seed in range(options.seeds)]
    plain = [kept(race, options.results, seed, options.runs, is_plain=True) for seed in range(options.plain_seeds)]
    twins = [kept(race, options.results, seed, options.twin_runs, repaired=True) for seed in range(options.twin_seeds)]
    firsts, plain_firsts = sorted(map(first, filter(fails, found))), sorted(map(first, filter(fails, plain)))
    late = sum(bool(races) and not fails(races) for races in found)
    failing = sum(map(fails, twins))
    middle, plain_middle = (f"{median(each):g}" if each else "" for each in (firsts, plain_firsts))
    last = str(firsts[-1]) if firsts else ""
    words = dict.fromkeys(
        f"\n    {race['failure_kind']}: {race['words']}" for races in (*found, *twins) for race in races
    )
    counts = (
        f"{race.name + ' (held out)' * race.is_held_out:<30}{f'{len(firsts)}{of}':>10}{middle:>8}{last:>6}"
        f"{f'{late}{of}':>11}{f'{len(plain_firsts)} of {options.plain_seeds}':>10}{plain_middle:>8}"
        f"{f'{failing} of {options.twin_seeds}':>9}"
    )
    return counts + "".join([*words][:3])


def fails(races: Races) -> bool:
    """Whether a session fails for what it found: what is only late, it lists."""
    return any(race["is_counted"] for race in races)


def first(races: Races) -> int:
    """After how many runs the first one was found that fails a session."""
    return min(int(race["found_after"]) for race in races if race["is_counted"])


def kept(race: Race, results: Path, seed: int, runs: int, *, repaired: bool = False, is_plain: bool = False) -> Races:
    """The races found in a session, which is run unless the file of results has it."""
    every = json.loads(results.read_text(encoding="utf-8")) if results.is_file() else {}
    variant = "repaired" if repaired else "plain" if is_plain else "robot"
    name = f"{race.name} {variant} {runs} {seed}"
    if name not in every:
        every[name] = search_races(race, seed, runs, repaired=repaired, is_plain=is_plain)
        lines = ",\n".join(f"{json.dumps(key)}: {json.dumps(every[key])}" for key in sorted(every))
        results.write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")
    races: Races = every[name]
    return races


def search_races(
    race: Race, seed: int, runs: int, *, repaired: bool = False, is_plain: bool = False, tests: int = TESTS
) -> Races:
    """The races found in a session.

    Raises:
        SessionError: the suite does not pass under the usual schedule, or the session ended before its end.
    """
    project = Project(race.name, ("robot",), arguments(seed, runs, tests), lambda at: race.write(at, repaired=repaired))
    post_session.search_schedules = _until_first(is_plain=is_plain)
    with tempfile.TemporaryDirectory() as folder:
        prepared(project, Path(folder) / race.name)
        ran(project, Path(folder) / race.name, None)
        report = json.loads((Path(folder) / race.name / "hri-report" / "report.json").read_text(encoding="utf-8"))
    failed = [test["id"] for test in report["tests"] if test["outcome"] != "passed"]
    if failed:
        raise session.SessionError(f"{race.name} fails under the usual schedule: {', '.join(failed)}")
    races = report["schedules"].get("races", [])
    return [{key: race[key] for key in ("found_after", "failure_kind", "is_counted", "words")} for race in races]


def _until_first(*, is_plain: bool) -> Callable[..., Any]:
    """Searches until a race is found that fails the session. To be called in a session of its own."""

    def search_schedules(session: FeatureSession, results: Any, runs: int) -> Any:
        hunt = post_session.RaceHunt
        keep = hunt.keep

        def keep_first(self: Any, *values: Any, **options: Any) -> None:
            keep(self, *values, **options)
            if any(race.is_counted for _, race in self.races):
                self.budget = 0

        hunt.keep = keep_first  # type: ignore[method-assign]
        if is_plain:
            search.TURNS = (search.ScheduleSearch._at_random,)
            search.ScheduleSearch._is_near = lambda self, conflict: False  # type: ignore[method-assign]
        return SEARCH_SCHEDULES(session, results, runs)

    return search_schedules


def arguments(seed: int, runs: int, tests: int) -> tuple[str, ...]:
    """The options of a session."""
    suite = ("--hri-suite=pseudorandom", f"--hri-tests={tests}", f"--hri-seed={seed}")
    return (*suite, f"--hri-schedules={runs}", "--hri-no-cov")


if __name__ == "__main__":
    main()
