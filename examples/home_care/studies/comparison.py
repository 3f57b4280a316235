"""This robot beside the published one: the published tests, run here, with the cause of each difference.

    python -m studies.comparison [--tests FILE] [--copies N] [--workers N] [--folder DIR]

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
from studies.results import Run, runs_of

HERE = Path(__file__).parent
PROJECT = HERE.parent
AS_IT_IS, AS_IT_WAS = "as it is", "as it was"
FAULTS = "CAREBOT_FAULTS"
"""The testbench reads the published faults to switch on from this environment variable."""

UNHEARD = "disturb order_lost"
"""The line by which the robot does not hear the next order."""

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
    blocks = []
    for test in tests:
        said, _ = lines(test)
        for copy in range(copies):
            drawn = Random(f"{seed} {test.method} {test.number} {copy}").random()
            lost = [UNHEARD] if drawn < unheard.get(test.method, 0.0) else []
            blocks.append("\n".join([f"# name: {test.name}", *lost, *said]) + "\n")
    return "\n".join(blocks)


def run_suite(text: str, environment: Mapping[str, str], workers: int) -> list[Run]:
    """Run a suite in a session of its own, and take what is needed from its report.

    Args:
        text: of the suite.
        environment: variables beside those that are set: which faults are on, and which dog it is.
        workers: processes.

    Raises:
        PublishedError: the session could not run.
    """
    with tempfile.TemporaryDirectory(prefix="home-care-") as folder:
        suite, report = Path(folder) / "published.txt", Path(folder) / "report"
        suite.write_text(text, encoding="utf-8")
        options = [f"--hri-suite={suite}", f"--hri-report={report}", "--hri-diagnose=0", "-q", "-p", "no:cacheprovider"]
        parallel = ["-n", str(workers)] if workers > 1 else []
        command = [sys.executable, "-m", "pytest", *options, *parallel]
        ended = subprocess.run(
            command, cwd=PROJECT, env={**os.environ, **environment}, capture_output=True, text=True, check=False
        )
        if ended.returncode not in RAN:
            raise PublishedError(f"{' '.join(command)} ended with {ended.returncode}:\n{ended.stdout}{ended.stderr}")
        return runs_of(json.loads((report / "report.json").read_text(encoding="utf-8")))


def compare(tests: Sequence[PublishedTest], copies: int, workers: int) -> Comparison:
    """Run the tests here, as they are and as they were."""
    unheard = {method: share for method, (_, _, share) in first_orders(tests).items()}
    faults = ",".join(SWITCHES)
    runs = {
        AS_IT_IS: run_suite(suite_text(tests, copies, {}), {FAULTS: "", DOG_VARIABLE: ""}, workers),
        AS_IT_WAS: run_suite(suite_text(tests, copies, unheard), {FAULTS: faults, DOG_VARIABLE: AS_PUBLISHED}, workers),
    }
    return Comparison(tests, copies, runs, unheard, faults)


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; 0, or 2 where the tests cannot be read or run."""
    parser = argparse.ArgumentParser(prog="python -m studies.comparison", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--tests", type=Path, default=DATA, help="tests by method (default: those known)")
    parser.add_argument("--copies", type=int, default=4, help="runs of each test (default: 4)")
    parser.add_argument("--workers", type=int, default=2, help="processes (default: 2)")
    parser.add_argument("--folder", type=Path, default=HERE, help="of the page and its figures (default: here)")
    parsed = parser.parse_args(arguments)
    try:
        compared = compare(read(parsed.tests), parsed.copies, parsed.workers)
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
