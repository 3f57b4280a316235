"""The paper's experiment, all of it: runs the four suites, writes docs/experiment.md and its pictures.

    python -m benchmarks.experiment [--report DIR] [--again]

It leaves the report in DIR (default hri-experiment); `--again` makes the page of the report that is there.
"""

from __future__ import annotations

import argparse
import json
import sys
from itertools import count
from pathlib import Path
from statistics import fmean
from typing import Any

from benchmarks import page, pictures, session
from benchmarks.end_to_end import machine
from benchmarks.experiment import charts, published
from benchmarks.experiment.comparison import Method, methods
from benchmarks.experiment.tables import tables

PICTURES = "pictures"
WORKERS = 2


def main() -> None:
    """Run, compare, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--report", type=Path, default=Path("hri-experiment"), metavar="DIR", help="the report's folder"
    )
    parser.add_argument("--docs", type=Path, default=session.ROOT / "docs", metavar="DIR", help="the page's folder")
    parser.add_argument("--again", action="store_true", help="do not run: make the page of the report that is there")
    options = parser.parse_args()
    folder = options.report.resolve()
    try:
        report = measured(read(folder) if options.again else run(folder))
    except session.SessionError as error:
        sys.exit(f"experiment: {error}")
    write(report, options.docs)
    print(f"written: {options.docs / 'experiment.md'}")


def run(folder: Path) -> dict[str, Any]:
    """The report of all four suites. Raises SessionError."""
    print("running all four suites on two workers ...", flush=True)
    done = session.run(folder, ["--hri-suite=all", "-n", str(WORKERS)])
    print(f"{done.report['reported']} tests in {done.wall_s:.0f} s", flush=True)
    return done.report


def read(folder: Path) -> dict[str, Any]:
    """The report in a folder. Raises SessionError where there is none, or it lacks a suite."""
    path = folder / "report.json"
    try:
        report: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise session.SessionError(f"{path}: no report ({error}); leave out --again to run the suites") from None
    missing = published.METHODS.keys() - {suite["name"] for suite in report.get("suites", ())}
    if missing:
        raise session.SessionError(f"{path}: a report without {', '.join(sorted(missing))}; leave out --again")
    return report


def measured(report: dict[str, Any]) -> dict[str, Any]:
    """The report, if it tells what code was covered. Raises SessionError where it does not."""
    for suite in report["suites"]:
        if suite["code"]["statements"] is None or suite["code"]["branches"] is None:
            reason = report["code_under_test"]["reason"]
            raise session.SessionError(f"suite {suite['name']}: the code under test was not measured: {reason}")
    return report


def write(report: dict[str, Any], docs: Path) -> None:
    """Write page and pictures."""
    found = methods(report)
    workers = int(report["workers"])
    for name, made in (
        ("coverage", charts.coverage(found)),
        ("learning", charts.learning(found["rl"])),
        ("growth", charts.growth(found)),
        ("time", charts.time(found, workers)),
    ):
        pictures.save(made, docs / PICTURES / f"experiment-{name}.svg")
    page.write(docs / "experiment.md", page.render("experiment/experiment.md.jinja", context(report, found)))


def context(report: dict[str, Any], found: dict[str, Method]) -> dict[str, Any]:
    """What the page's template is filled with."""
    workers = int(report["workers"])
    return {
        "report": report,
        "methods": found,
        "tables": tables(found, workers),
        "failures": failures(report),
        "resting": [each for each in found.values() if each.verdicts["R4"][2]],
        "machine": machine(),
        "published": published,
        "workers": workers,
        "silent_turns": sum(test["legs"].count("sensing-timeout") for test in report["tests"]),
        # What a draw gives on average: sequences of 4 to 19 of ten commands, and poses of one to four legs.
        "silent_expected": 100.0 * fmean(0.9**length for length in range(4, 20)),
        "good_expected": 100.0 * fmean(1 - (7 / 8) ** legs for legs in (1, 2, 3, 4)),
        "quiet_from": next(n for n in count(1) if 0.1 * 0.9 ** (n - 1) * 444.5 < published.TOLERANCE),
    }


def failures(report: dict[str, Any]) -> list[dict[str, str]]:
    """Tests that failed something not known to fail, and what caused it as far as the test's parameters tell."""
    found = []
    for test in report["tests"]:
        if test["outcome"] not in ("failed", "error"):
            continue
        failed = [name for name, each in test["requirements"].items() if each["verdict"] == "Failed"]
        grips = [action["parameters"].get("grip_s", 0.0) for action in test["concrete"]["actions"]]
        cause = f": a person grips the fingers with the leg for {max(grips):.1f} s, as the original's one slow release"
        slow = failed == ["R1"] and max(grips, default=0.0) > 0.0
        what = " and ".join(failed) or "an error"
        found.append({"what": what, "test": test["id"], "cause": cause if slow else ""})
    return found


if __name__ == "__main__":
    main()
