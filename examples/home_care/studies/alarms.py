"""False alarms: suites at several seeds, of the robot as it is. Nothing may fail but what is declared as known.

    python -m studies.alarms [--seeds N] [--first SEED] [--suites NAME,...] [--tests N]
                             [--workers N] [--folder DIR] [--keep DIR]

At each seed there is a session of each suite, of so many tests; one process of pytest runs those of a seed. With
`--keep`, their reports stay there, and sessions that are there already, of the same robot and size, are not run again:
so who stops the command goes on where it was. The page is `alarms.md`; the exit status is 1 where there is an alarm.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
PROJECT = HERE.parent
SUITES = "by-hand,pseudorandom,bdi-random,rl"
DECLARED = ("passed", "known-violation")
"""Outcomes of a test in which nothing came otherwise than the project declares."""

RAN = (0, 1)
"""Exit statuses of pytest after which there is a report: all passed, or some failed."""

MADE_OF = ("carebot", "house", "people", "models_bdi", "tests/requirements.toml", "tests/by_hand.toml", "conftest.py")
"""What a run depends on, of this project: its hash says whether a kept session is one of the robot as it is."""

VARIABLES = ("CAREBOT_FAULTS", "HOME_CARE_DOG")
"""Environment variables that make the robot or the dog another one: unset here."""


class AlarmsError(Exception):
    """A session could not run; the text says why."""


@dataclass(frozen=True)
class Alarm:
    """A test that failed, of which suite and seed, and what was wrong with it."""

    test: str
    suite: str
    seed: int
    text: str


@dataclass(frozen=True)
class Seeded:
    """The sessions of a seed.

    Args:
        seed: of the suites.
        tests: suite -> how many.
        known: tests with violations, all of which are known under the conditions that hold there.
        simulated_s: of all runs.
        triggered: requirement -> runs that triggered it.
        alarms: what failed otherwise.
    """

    seed: int
    tests: Mapping[str, int]
    known: int
    simulated_s: float
    triggered: Mapping[str, int]
    alarms: tuple[Alarm, ...]


def seeded(seed: int, report: Mapping[str, Any]) -> Seeded:
    """What a report says of the sessions of a seed."""
    tests = report["tests"]
    suites = [suite["name"] for suite in report["suites"]]
    names = list(report["requirements"])
    return Seeded(
        seed=seed,
        tests={suite: sum(test["suite"] == suite for test in tests) for suite in suites},
        known=sum(test["outcome"] == "known-violation" for test in tests),
        simulated_s=sum(test["sim_s"] for test in tests),
        triggered={name: sum(_triggers(test, name) > 0 for test in tests) for name in names},
        alarms=tuple(_alarms(seed, report)),
    )


def _triggers(test: Mapping[str, Any], name: str) -> int:
    return int(test["requirements"].get(name, {"triggers": 0})["triggers"])


def _alarms(seed: int, report: Mapping[str, Any]) -> Iterator[Alarm]:
    for test in report["tests"]:
        if test["outcome"] not in DECLARED:
            text = " ".join(test["failure"].split()) or test["outcome"]
            yield Alarm(test["id"], test["suite"], seed, text[:200])
    missing = int(report["selected"]) - int(report["reported"])
    if missing:
        yield Alarm(f"{missing} tests", "all", seed, "have no result")


def page(sessions: Sequence[Seeded], asked: str) -> str:
    """The page, in Markdown.

    Args:
        sessions: those of each seed.
        asked: the command.
    """
    suites = list(sessions[0].tests)
    runs = sum(sum(held.tests.values()) for held in sessions)
    alarms = [alarm for held in sessions for alarm in held.alarms]
    sizes = f"{len(sessions) * len(suites)} sessions: {len(suites)} suites at {len(sessions)} seeds each"
    hours = sum(held.simulated_s for held in sessions) / 3600.0
    lines = [
        "# False alarms",
        "",
        f"Written by `{asked}`. The robot as it is, with no fault on and a dog that walks, was run {runs:,} times in",
        f"{sizes}; {hours:.1f} h are simulated. An alarm is all that fails",
        "a test, except known violations under the conditions under which they are known.",
        "",
        f"**{len(alarms)} of {runs:,} runs have a false alarm.** {sum(held.known for held in sessions):,} have known "
        "violations.",
        "",
        "| suite | seeds | runs | alarms |",
        "| --- | --- | --- | --- |",
        *(
            f"| {suite} | {len(sessions)} | {sum(held.tests[suite] for held in sessions)} "
            f"| {sum(alarm.suite == suite for alarm in alarms)} |"
            for suite in suites
        ),
        "",
        "| requirement | runs that triggered it |",
        "| --- | --- |",
        *(f"| {name} | {sum(held.triggered[name] for held in sessions)} |" for name in sessions[0].triggered),
        "",
        *(f"- {alarm.test}, seed {alarm.seed}: {alarm.text}" for alarm in alarms),
        *([""] if alarms else []),
    ]
    return "\n".join(lines)


def robot_sha256() -> str:
    """Of all that a run depends on in this project."""
    digest = sha256()
    for name in MADE_OF:
        path = PROJECT / name
        files = [path] if path.is_file() else sorted(file for file in path.rglob("*") if file.suffix in _SOURCES)
        for file in files:
            digest.update(file.relative_to(PROJECT).as_posix().encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()


_SOURCES = (".py", ".asl", ".mas2j", ".toml")


def _held(folder: Path, made_with: str) -> Mapping[str, Any] | None:
    """The report of sessions that are there already; None where there is none, or one of something else."""
    report, made = folder / "report.json", folder / "made_with.json"
    if not (report.exists() and made.exists()) or made.read_text(encoding="utf-8") != made_with:
        return None
    read: Mapping[str, Any] = json.loads(report.read_text(encoding="utf-8"))
    return read


def _run(seed: int, suites: str, tests: int, workers: int, folder: Path) -> None:
    options = [f"--hri-suite={suites}", f"--hri-tests={tests}", f"--hri-seed={seed}", f"--hri-report={folder}"]
    fixed = ["--hri-no-cov", "--hri-diagnose=0", "--hri-audit=off", "-q", "-p", "no:cacheprovider"]
    shared = ["-n", str(workers)] if workers > 1 else []
    command = [sys.executable, "-m", "pytest", *options, *fixed, *shared]
    environment = {name: value for name, value in os.environ.items() if name not in VARIABLES}
    ended = subprocess.run(command, cwd=PROJECT, env=environment, capture_output=True, text=True, check=False)
    if ended.returncode not in RAN:
        raise AlarmsError(f"{' '.join(command)} ended with {ended.returncode}:\n{ended.stdout}{ended.stderr}")


def sessions_of(seeds: Iterable[int], suites: str, tests: int, workers: int, keep: Path) -> Iterator[Seeded]:
    """The sessions of one seed after the other; those that `keep` has are read.

    Raises:
        AlarmsError: a session could not run.
    """
    made_with = json.dumps({"robot": robot_sha256(), "suites": suites, "tests": tests})
    for seed in seeds:
        folder = keep / f"seed-{seed}"
        report = _held(folder, made_with)
        if report is None:
            (folder / "made_with.json").unlink(missing_ok=True)
            _run(seed, suites, tests, workers, folder)
            (folder / "made_with.json").write_text(made_with, encoding="utf-8")
            report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
        yield seeded(seed, report)


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; 0, 1 where there is an alarm, or 2 where a session cannot run."""
    parser = argparse.ArgumentParser(prog="python -m studies.alarms", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--seeds", type=int, default=10, help="so many (default: 10)")
    parser.add_argument("--first", type=int, default=0, help="the first of them (default: 0)")
    parser.add_argument("--suites", default=SUITES, help=f"comma-separated (default: {SUITES})")
    parser.add_argument("--tests", type=int, default=4, help="of each suite at each seed (default: 4)")
    parser.add_argument("--workers", type=int, default=2, help="processes (default: 2)")
    parser.add_argument("--folder", type=Path, default=HERE, help="of the page (default: here)")
    parser.add_argument("--keep", type=Path, help="keep the reports here, and run only what is not there")
    parsed = parser.parse_args(arguments)
    sessions: list[Seeded] = []
    try:
        with tempfile.TemporaryDirectory(prefix="home-care-") as scratch:
            keep = (parsed.keep or Path(scratch)).resolve()
            seeds = range(parsed.first, parsed.first + parsed.seeds)
            for held in sessions_of(seeds, parsed.suites, parsed.tests, parsed.workers, keep):
                sessions.append(held)
                said = f"seed {held.seed}: {sum(held.tests.values())} runs, {len(held.alarms)} alarms"
                print(said, *(f"  {alarm.test}: {alarm.text}" for alarm in held.alarms), sep="\n", flush=True)
    except AlarmsError as error:
        print(error, file=sys.stderr)
        return 2
    parsed.folder.mkdir(parents=True, exist_ok=True)
    first = f" --first {parsed.first}" if parsed.first else ""
    asked = f"python -m studies.alarms --seeds {parsed.seeds}{first} --tests {parsed.tests}"
    (parsed.folder / "alarms.md").write_text(page(sessions, asked), encoding="utf-8")
    print(parsed.folder / "alarms.md")
    return 1 if any(held.alarms for held in sessions) else 0


if __name__ == "__main__":
    sys.exit(main())
