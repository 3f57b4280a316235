"""How much drafts find in code that they were not built with, how right that is, and whether they are green.

    python -m studies.draft_corpus [--only courier,kiosk]        # the robots of this project (a few minutes each)
    python -m studies.draft_corpus --clones FOLDER               # public ones as well, cloned into a folder
    python -m studies.draft_corpus --static                      # only read the code (seconds)
    python -m studies.draft_corpus --sealed --totals --page      # those that nobody looks at; the tables of the page

An *element* is a kind of message that the code receives (a call, or an answer of a device, counts), a text that it
tells apart in them, or a state. Elements are compared by their names, without case and signs. Each robot is measured
from its code alone; after first runs; and, where it has a demo or tests, with a recording of them.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import chdir
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.extra.draft.command import DraftOptions, prepare
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.files import write
from pytest_hricdv.extra.draft.settling import settle
from studies.code_bases.ros2 import fetch
from studies.draft_corpus import FOLDER, Robot, counts, elements, robots
from studies.page import replace_figures, table

PAGE = FOLDER.parents[1] / "docs" / "studies" / "drafts.md"
COMMAND = "python -m studies.draft_corpus --sealed --totals --page"
MODES = ("code", "runs", "recording")
NAMES = {"code": "from its code alone", "runs": "with first runs", "recording": "with a recording"}
HEAD = ("drafts", "robots", "recall", "precision", "green", "hollow", "longest to green")


@dataclass(frozen=True)
class Measurement:
    """A draft of a robot.

    Args:
        found: as `counts` returns it.
        green: whether the suites `rl` and `closure` pass, and are not empty; None where they were not run.
        hollow: whether nothing that people do reaches the code.
        took_s: processor time of the draft, and of the suite `rl`.
    """

    found: tuple[int, int, int, int]
    green: bool | None = None
    hollow: bool = False
    took_s: float = 0.0


def measure(robot: Robot, mode: str, folder: Path, say: bool) -> Measurement:
    """Draft for a robot whose code is in a folder; `say` prints what is missing and wrong."""
    begin_s = _processor_s()
    with chdir(folder):
        recordings = _record(robot) if mode == "recording" else ()
        target = folder / f"hri-{mode}"
        prepared = prepare(robot.asked[0].strip("-"), robot.asked[1], DraftOptions(target, recordings=recordings))
        draft = prepared.draft
        if mode != "code" and prepared.is_runnable:
            draft, _ = settle(draft, prepared.reread, progress=lambda line: print("   ", line) if say else None)
        found = counts(elements(draft), robot)
        if say:
            print(*_differences(draft, robot), sep="\n")
        if mode == "code":
            return Measurement(found)
        write(draft, target)
    green = _passes(target, "rl")
    took_s = _processor_s() - begin_s
    if prepared.is_runnable:
        return Measurement(found, green and _passes(target, "closure"), bool(draft.hollow), took_s)
    return Measurement(found)


def _record(robot: Robot) -> tuple[Path, ...]:
    """The recording of a robot's demo or tests. Raises subprocess.CalledProcessError where there is nothing in it."""
    output = Path.cwd() / "recording.json"
    package = robot.asked[1].partition(":")[0].rpartition("/")[2]
    command = [sys.executable, "-m", "pytest_hricdv", "record", "--package", package, "-o", str(output), "--"]
    subprocess.run([*command, *robot.record], check=True, capture_output=True)
    return (output,)


def _passes(folder: Path, suite: str) -> bool:
    """Whether a suite of a draft passes, and has tests."""
    command = [sys.executable, "-m", "pytest", "-q", f"--hri-suite={suite}"]
    environment = {**os.environ, "PYTHONPATH": str(FOLDER.parents[1])}
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, env=environment)
    report = folder / "hri-report" / "report.json"
    tests = json.loads(report.read_text(encoding="utf-8"))["tests"] if report.exists() else ()
    return done.returncode == 0 and bool(tests)


def _processor_s() -> float:
    """Processor time of all processes that have ended: the machine's other work does not count."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _differences(draft: Draft, robot: Robot) -> Iterator[str]:
    found = elements(draft)
    for word, these, others in (("missing", robot.truth, found), ("wrong", found, (*robot.truth, *robot.also))):
        for each in these:
            if not any(map(each.is_like, others)):
                yield f"    {word}: {each.kind} {min(each.names)}"


def code_of(robot: Robot, clones: Path | None, folder: Path) -> Path | None:
    """A copy of a robot's code in a folder; None for one that would have to be cloned, without a folder for that."""
    target = folder / robot.key
    if not robot.repository:
        shutil.copytree(FOLDER / "robots" / robot.key, target / robot.key)
        return target
    if clones is None:
        return None
    clone = clones / robot.repository.rpartition("/")[2]
    fetch(clone, robot.repository, robot.commit)
    shutil.copytree(clone, target, ignore=shutil.ignore_patterns(".git"), symlinks=True)
    return target


def totals(measured: Sequence[Measurement]) -> tuple[str, ...]:
    """A row of the table."""
    found, of, right, named = (sum(each.found[place] for each in measured) for place in range(4))
    ran = [each for each in measured if each.green is not None]
    green, hollow = sum(bool(each.green) for each in ran), sum(each.hollow for each in ran)
    longest_s = max((each.took_s for each in ran), default=0.0)
    tested = (f"{green} of {len(ran)}", f"{hollow} of {len(ran)}", f"{longest_s:.0f} s") if ran else ("-", "-", "-")
    return (str(len(measured)), f"{100 * found / max(of, 1):.0f} % of {of}",
            f"{100 * right / max(named, 1):.0f} % of {named}", *tested)  # fmt: skip


def main() -> None:
    """Measure, and print or write the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--clones", type=Path, metavar="FOLDER", help="of public repositories, cloned where missing")
    parser.add_argument("--only", default="", metavar="KEYS", help="of some robots, such as courier,kiosk")
    parser.add_argument("--static", action="store_true", help="only read the code")
    parser.add_argument("--sealed", action="store_true", help="those that nobody looks at, in place of the others")
    parser.add_argument("--totals", action="store_true", help="print nothing of a single robot")
    parser.add_argument("--modes", default=",".join(MODES), metavar="MODES", help="of code, runs, recording")
    parser.add_argument("--page", action="store_true", help="write the table to the page")
    options = parser.parse_args()
    modes = ("code",) if options.static else tuple(options.modes.split(","))
    measured: dict[str, list[Measurement]] = {mode: [] for mode in modes}
    only = list(filter(None, options.only.split(",")))
    for robot in robots():
        if robot.sealed != options.sealed or (only and robot.key not in only):
            continue
        for mode in modes:
            with tempfile.TemporaryDirectory() as name:
                code = code_of(robot, options.clones and options.clones.resolve(), Path(name).resolve())
                if code is None or (mode == "recording" and not robot.record):
                    continue
                made = measure(robot, mode, code, not options.totals)
            measured[mode].append(made)
            if not options.totals:
                print(robot.key, mode, *totals([made])[1:], flush=True)
    text = table(HEAD, [[NAMES[mode], *totals(rows)] for mode, rows in measured.items() if rows])
    print(text)
    if options.page:
        replace_figures(PAGE, COMMAND, text)


if __name__ == "__main__":
    main()
