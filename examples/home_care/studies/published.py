"""The published tests of the home-care case as suites, and its published results.

    python -m studies.published --write DIR [FILE]     suites for --hri-suite=DIR/published-bdi.txt
    python -m studies.published --summarize [FILE]     FILE's runs as counts, as they are in published.json

FILE has tests by method, as the data that the figures are from: `{"methods": {"bdi": {"tests": [{"n": 1, "steps":
["feed", "clean"], "runs": [...]}]}}}`, or without the outer names, `{"bdi": [{"n": 1, "steps": [...]}]}`. By default it
is `published.json` here: the half of the tests that is known, with the outcomes of their runs counted. It has facts
only, of github.com/robosafe/mc-vs-bdi at c8bcfd2, folders tests/ and data/.

A step is an order, and becomes a line of a test as it is. The format is all that differs, but for two cases, each
of which is said: a time-out is the person's `rest`, and an order that no test here knows is asked as `whatever`, which
the robot cannot do either.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from people.ranges import COMMANDS, KNOWN

DATA = Path(__file__).with_name("published.json")
REQUIREMENTS = ("A1", "A2", "A3", "A4")
VERDICTS = ("Passed", "Failed", "NC")
CODES = "PFN"
"""Of `VERDICTS`, in the runs of the data."""

NOT_STARTED_PERCENT = 24
"""The coverage of runs in which the simulator did not start, and only of those."""

REST, UNKNOWN = "rest", "whatever"
TIMEOUT = "timeout"


class PublishedError(Exception):
    """A file has no such tests; the text says where, what was expected, and what came."""


@dataclass(frozen=True)
class Counts:
    """The runs of a test.

    Args:
        runs: all of them.
        started: those in which the simulator started; all other fields are of these.
        verdicts: for each of A1 to A4, how many Passed, Failed, and were not checked.
        coverage_sum: of the statements' coverage in %.
        unmoved: those in which the robot carried out nothing.
    """

    runs: int
    started: int
    verdicts: tuple[tuple[int, int, int], ...]
    coverage_sum: int
    unmoved: int


@dataclass(frozen=True)
class PublishedTest:
    """A test of the original: its method, its number there, its steps, and its runs, where they are known."""

    method: str
    number: int
    steps: tuple[str, ...]
    counts: Counts | None = None

    @property
    def name(self) -> str:
        """Its title in a suite."""
        return f"published {self.method} {self.number}"


def read(path: Path = DATA) -> list[PublishedTest]:
    """The tests of a file.

    Raises:
        PublishedError: it has none, or something else in their place.
    """
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise PublishedError(f"{path}: {error.strerror}; expected a JSON file of tests by method") from None
    except ValueError as error:
        raise PublishedError(f"{path}: {error}; expected a JSON file of tests by method") from None
    methods = data.get("methods", data) if isinstance(data, dict) else None
    if not isinstance(methods, dict):
        raise PublishedError(f'{path}: expected {{"methods": {{"bdi": {{"tests": [...]}}}}}}')
    tests = []
    for method, held in methods.items():
        entries = held.get("tests") if isinstance(held, dict) else held
        if not isinstance(entries, list):
            continue  # such as a text on what the file is
        tests += [_test(f"{path}: method {method!r}", method, place, entry) for place, entry in enumerate(entries, 1)]
    if not tests:
        raise PublishedError(f"{path}: no tests in it; expected a list of tests with 'steps' by method")
    return tests


def _test(where: str, method: str, place: int, entry: Any) -> PublishedTest:
    steps = entry.get("steps", ()) if isinstance(entry, dict) else ""
    if not isinstance(steps, list | tuple | None) or not all(isinstance(step, str) for step in steps or ()):
        raise PublishedError(f"{where}, entry {place}: {entry!r}; expected an object with 'steps', a list of orders")
    try:
        counts = counted(entry["runs"]) if "runs" in entry else _counts(entry.get("counts"))
        return PublishedTest(method, int(entry.get("n", place)), tuple(steps or ()), counts)
    except (ValueError, KeyError, TypeError, IndexError) as error:
        raise PublishedError(
            f"{where}, entry {place}: {error!r}; expected 'n', a number, and 'runs', texts such as 'PPPF84:1011'"
        ) from None


def _counts(data: Mapping[str, Any] | None) -> Counts | None:
    if data is None:
        return None
    verdicts = tuple((row[0], row[1], row[2]) for row in data["verdicts"])
    return Counts(data["runs"], data["started"], verdicts, data["coverage_sum"], data["unmoved"])


def counted(runs: Sequence[str]) -> Counts:
    """The counts of runs in the data's short form, such as "PPPF84:1011".

    That is: the verdicts of A1 to A4, the coverage of statements in %, and how often the robot's state machines began
    with Fridge, Sink and Human, and how often it was idle.
    """
    started = [run for run in runs if _coverage(run) != NOT_STARTED_PERCENT]
    verdicts = tuple(
        (
            sum(run[place] == CODES[0] for run in started),
            sum(run[place] == CODES[1] for run in started),
            sum(run[place] == CODES[2] for run in started),
        )
        for place in range(len(REQUIREMENTS))
    )
    unmoved = sum(run.partition(":")[2][:3] == "000" for run in started)
    return Counts(len(runs), len(started), verdicts, sum(map(_coverage, started)), unmoved)


def _coverage(run: str) -> int:
    return int(run.partition(":")[0][len(REQUIREMENTS) :])


def first_orders(tests: Sequence[PublishedTest]) -> dict[str, tuple[int, int, float]]:
    """In how many runs the robot did not hear the first order: method -> runs, those without, and their share, 0 to 1.

    That shows where the first order is the only one that the robot can do: then it carries out nothing in such a run.
    """
    heard: dict[str, tuple[int, int, float]] = {}
    for method in dict.fromkeys(test.method for test in tests):
        counts = [test.counts for test in tests if test.method == method and _only_first_known(test) and test.counts]
        runs, unmoved = sum(count.started for count in counts), sum(count.unmoved for count in counts)
        heard[method] = runs, unmoved, unmoved / runs if runs else 0.0
    return heard


def _only_first_known(test: PublishedTest) -> bool:
    return [step in KNOWN for step in test.steps] == [True, *(False for _ in test.steps[1:])]


def lines(test: PublishedTest) -> tuple[list[str], list[str]]:
    """The lines of a test, and what had to be said in another way, a sentence each."""
    said, notes = [], []
    for step in test.steps:
        name = _bare(step)
        if name == TIMEOUT:
            said.append(REST)
            notes.append(f"{test.name}: step {step!r} is a line {REST!r}: the person orders nothing")
        elif name in _COMMANDS:
            said.append(_COMMANDS[name])
        else:
            said.append(UNKNOWN)
            notes.append(f"{test.name}: step {step!r} is no order of any test here; it is asked as {UNKNOWN!r}")
    if not said:
        return [REST], [f"{test.name}: no steps; it is a line {REST!r}: the person orders nothing"]
    return said, notes


def _bare(name: str) -> str:
    """A name without capitals and what separates words: "open door", "open_door" and "opendoor" are one."""
    return "".join(name.lower().replace("-", " ").replace("_", " ").split())


_COMMANDS = {_bare(command): command for command in COMMANDS}


def suites(tests: Sequence[PublishedTest], first: str = "") -> Iterator[tuple[str, str, list[str]]]:
    """A suite for each method: its name, its text, and the notes.

    Args:
        tests: of all methods.
        first: a line that each test begins with, such as a disturbance.
    """
    for method in dict.fromkeys(test.method for test in tests):
        name, blocks, notes = f"published-{method}", [], []
        for test in (test for test in tests if test.method == method):
            said, own = lines(test)
            notes += own
            blocks.append("\n".join([f"# name: {test.name}", *([first] if first else []), *said]) + "\n")
        yield name, "\n".join(blocks), notes


def summary(tests: Sequence[PublishedTest]) -> dict[str, Any]:
    """The data of `published.json`."""
    methods: dict[str, dict[str, list[dict[str, Any]]]] = {}
    for test in tests:
        entry: dict[str, Any] = {"n": test.number, "steps": list(test.steps)}
        if (counts := test.counts) is not None:
            entry["counts"] = {
                "runs": counts.runs,
                "started": counts.started,
                "verdicts": [list(row) for row in counts.verdicts],
                "coverage_sum": counts.coverage_sum,
                "unmoved": counts.unmoved,
            }
        methods.setdefault(test.method, {"tests": []})["tests"].append(entry)
    about = (
        "Facts of the home-care case of Araiza-Illan, Pipe and Eder, counted from the data of "
        "github.com/robosafe/mc-vs-bdi at c8bcfd2: of each test its steps, and of its runs with 41 seeds how many "
        "there were, how many started, and of these the verdicts (Passed, Failed, not checked) of A1 to A4, the sum of "
        "their statement coverage in %, and in how many the robot carried out nothing."
    )
    return {"about": about, "methods": methods}


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; 0, or 2 where the file cannot be read."""
    parser = argparse.ArgumentParser(prog="python -m studies.published", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("file", nargs="?", type=Path, default=DATA, help="tests by method (default: those known)")
    doing = parser.add_mutually_exclusive_group(required=True)
    doing.add_argument("--write", metavar="DIR", type=Path, help="write a suite for each method into this folder")
    doing.add_argument("--summarize", action="store_true", help="print the counts of the file's runs")
    parsed = parser.parse_args(arguments)
    try:
        tests = read(parsed.file)
    except PublishedError as error:
        print(error, file=sys.stderr)
        return 2
    if parsed.summarize:
        print(json.dumps(summary(tests), separators=(",", ":")))
        return 0
    parsed.write.mkdir(parents=True, exist_ok=True)
    for name, text, notes in suites(tests):
        path = parsed.write / f"{name}.txt"
        path.write_text(text, encoding="utf-8")
        print(f"{path}: {text.count('# name:')} tests")
        for note in notes:
            print(f"note: {note}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
