"""This robot beside the published one: the published tests, run here, with the cause of each difference.

    python -m studies.comparison [--tests FILE] [--copies N] [--sample N] [--workers N] [--folder DIR] [--keep DIR]

Each test is run N times (4 if nothing is said) as it is, and N times as it was: with the published faults switched on,
the first order unheard as often as in the published runs, and, where the world can do that, the dog that jumps. The
page is `comparison.md`, its figures are in `comparison.json`. FILE has tests as `studies.published` reads them.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from random import Random

from carebot.config import SWITCHES
from people.dog import AS_PUBLISHED, DOG_VARIABLE

from studies.page import Comparison
from studies.published import DATA, PublishedError, PublishedTest, first_orders, lines, read
from studies.results import UNHEARD, Run, runs_of

HERE = Path(__file__).parent
PROJECT = HERE.parent
AS_IT_IS, AS_IT_WAS = "as it is", "as it was"
FAULTS = "CAREBOT_FAULTS"
"""The testbench reads the published faults to switch on from this environment variable."""

RAN = (0, 1)
"""Exit statuses of pytest after which there is a report: all passed, or some failed."""


def suite_text(tests: Sequence[PublishedTest], copies: int, unheard: Mapping[str, float], seed: int = 0) -> str:
    """A suite of the tests, each so many times; in so many of them the robot does not hear the first order.

    Args:
        tests: of one method or several.
        copies: of each test; each has a seed of its own.
        unheard: method -> share of runs, 0 to 1, in which the first order is not heard. Which those are is drawn.
        seed: of this drawing.
    """
    lost = _unheard(tests, copies, unheard, seed)
    blocks = []
    for test in tests:
        said, _ = lines(test)
        for copy in range(copies):
            first = [UNHEARD] if (test.method, test.number, copy) in lost else []
            blocks.append("\n".join([f"# name: {test.name}", *first, *said]) + "\n")
    return "\n".join(blocks)


def _unheard(
    tests: Sequence[PublishedTest], copies: int, unheard: Mapping[str, float], seed: int
) -> set[tuple[str, int, int]]:
    """Which copies of which tests are those without a first order: of each method as many as its share says."""
    lost: set[tuple[str, int, int]] = set()
    for method, share in unheard.items():
        runs = [(method, test.number, copy) for test in tests if test.method == method for copy in range(copies)]
        Random(f"{seed} {method}").shuffle(runs)
        lost |= set(runs[: round(share * len(runs))])
    return lost


def run_suite(text: str, environment: Mapping[str, str], workers: int, keep: Path) -> list[Run]:
    """Run a suite in a session of its own, and take what is needed from its report.

    Args:
        text: of the suite.
        environment: variables beside those that are set: which faults are on, and which dog it is.
        workers: processes.
        keep: the folder of the session. Where it has a report of this suite and environment, nothing is run.

    Raises:
        PublishedError: the session could not run.
    """
    suite, report, made_with = keep / "published.txt", keep / "report", keep / "environment.json"
    asked = json.dumps(dict(environment))
    held = (report / "report.json", suite, made_with)
    if not all(path.exists() for path in held) or [_text(suite), _text(made_with)] != [text, asked]:
        keep.mkdir(parents=True, exist_ok=True)
        suite.write_text(text, encoding="utf-8")
        made_with.write_text(asked, encoding="utf-8")
        _session(suite, report, environment, workers)
    return runs_of(json.loads(_text(report / "report.json")))


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def _session(suite: Path, report: Path, environment: Mapping[str, str], workers: int) -> None:
    options = [
        f"--hri-suite={suite}",
        f"--hri-report={report}",
        "--hri-diagnose=0",
        "--hri-audit=off",
        "-q",
        "-p",
        "no:cacheprovider",
    ]
    command = [sys.executable, "-m", "pytest", *options, *(["-n", str(workers)] if workers > 1 else [])]
    ended = subprocess.run(
        command, cwd=PROJECT, env={**os.environ, **environment}, capture_output=True, text=True, check=False
    )
    if ended.returncode not in RAN:
        raise PublishedError(f"{' '.join(command)} ended with {ended.returncode}:\n{ended.stdout}{ended.stderr}")


def compare(known: Sequence[PublishedTest], sample: int, copies: int, workers: int, keep: Path) -> Comparison:
    """Run the tests here, as they are and as they were; the sessions are kept in two folders in `keep`."""
    tests = sampled(known, sample)
    unheard = unheard_shares(tests)
    faults = ",".join(SWITCHES)
    now, then = {FAULTS: "", DOG_VARIABLE: ""}, {FAULTS: faults, DOG_VARIABLE: AS_PUBLISHED}
    runs = {
        AS_IT_IS: run_suite(suite_text(tests, copies, {}), now, workers, keep / "now"),
        AS_IT_WAS: run_suite(suite_text(tests, copies, unheard), then, workers, keep / "then"),
    }
    return Comparison(tests, known, copies, runs, unheard, faults)


def unheard_shares(tests: Sequence[PublishedTest]) -> dict[str, float]:
    """Method -> share of runs, 0 to 1, in which the robot did not hear the first order.

    Where the tests do not show it, as those without published runs, it is that of the tests that are known.
    """
    known = first_orders(read(DATA))
    return {
        method: share if runs else known.get(method, (0, 0, 0.0))[2]
        for method, (runs, _, share) in first_orders(tests).items()
    }


def sampled(tests: Sequence[PublishedTest], count: int) -> list[PublishedTest]:
    """So many tests of each method, evenly spaced; all where there are no more, or `count` is 0."""
    chosen: list[PublishedTest] = []
    for method in dict.fromkeys(test.method for test in tests):
        own = [test for test in tests if test.method == method]
        kept = min(count or len(own), len(own))
        chosen += [own[len(own) * place // kept] for place in range(kept)]
    return chosen


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; 0, or 2 where the tests cannot be read or run."""
    parser = argparse.ArgumentParser(prog="python -m studies.comparison", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--tests", type=Path, default=DATA, help="tests by method (default: those known)")
    parser.add_argument("--copies", type=int, default=4, help="runs of each test (default: 4)")
    parser.add_argument("--workers", type=int, default=2, help="processes (default: 2)")
    parser.add_argument("--folder", type=Path, default=HERE, help="of the page and its figures (default: here)")
    parser.add_argument(
        "--sample", type=int, default=0, help="only so many tests of each method, evenly spaced (0: all)"
    )
    parser.add_argument("--keep", type=Path, help="keep the sessions here, and make the page of those that are there")
    parsed = parser.parse_args(arguments)
    try:
        with tempfile.TemporaryDirectory(prefix="home-care-") as scratch:
            keep = (parsed.keep or Path(scratch)).resolve()
            compared = compare(read(parsed.tests), parsed.sample, parsed.copies, parsed.workers, keep)
    except PublishedError as error:
        print(error, file=sys.stderr)
        return 2
    parsed.folder.mkdir(parents=True, exist_ok=True)
    (parsed.folder / "comparison.json").write_text(json.dumps(compared.data(), indent=1) + "\n", encoding="utf-8")
    (parsed.folder / "comparison.md").write_text(compared.text(), encoding="utf-8")
    print(parsed.folder / "comparison.md")
    return 0


if __name__ == "__main__":
    sys.exit(main())
