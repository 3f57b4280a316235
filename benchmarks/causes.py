"""Cost of causes: thousands of failing tests grouped, and the share of a diagnosis in sessions of three testbenches.

    python -m benchmarks.causes [REPORT] [--tests N] [--repeat N] [--projects NAME,...]

REPORT is a real report.json with failing tests (default hri-report/report.json): these are repeated under new names
until there are N (7,000), and grouped without experiments, as a session does first. Then, of each testbench of
`studies.localization` that is named, a session without a fault and one with the first of its planted faults that make
tests fail: the processor time of its diagnosis, forks included, in per cent of the session's without it.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage
from typing import Any

from msgspec.structs import replace

from benchmarks.report_page import grown
from pytest_hricdv.extra.diagnosis import causes
from pytest_hricdv.extra.diagnosis.grouping import ExperimentEvidence
from pytest_hricdv.extra.diagnosis.subject import Subject
from pytest_hricdv.results.codec import ReportError, load
from pytest_hricdv.results.model import Report
from studies.localization.faults import Fault, planted
from studies.localization.projects import PROJECTS, Project
from studies.localization.sessions import prepared, ran
from studies.session import machine

DIAGNOSED = causes.diagnose

COST = "diagnosis-s.txt"
"""In a testbench's folder: processor time (s) of the last session's diagnosis."""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("report", nargs="?", type=Path, default=Path("hri-report"))
    parser.add_argument("--tests", type=int, default=7000, metavar="N")
    parser.add_argument("--repeat", type=int, default=3, metavar="N")
    parser.add_argument("--projects", default="coffee,vacuum,table", metavar="NAME,...", help="(all three)")
    options = parser.parse_args()
    print(machine())
    with suppress(ReportError):
        _print_grouping(load(options.report), options)
    for project in PROJECTS:
        if project.name in options.projects.split(","):
            with tempfile.TemporaryDirectory() as folder:
                _print_shares(project, Path(folder))


def _print_grouping(report: Report, options: argparse.Namespace) -> None:
    failing = replace(report, tests=tuple(test for test in report.tests if test.went_wrong))
    many = grown(failing, options.tests)
    times_s = []
    for _ in range(options.repeat):
        began_s = time.process_time()
        subject = Subject.of(many)
        groups = subject.groups(ExperimentEvidence())
        times_s.append(time.process_time() - began_s)
    kinds = f"{len(failing.tests)} of {options.report}, {len(groups)} causes"
    print(f"{len(many.tests)} failing tests ({kinds}): grouped in {min(times_s):.2f} s")


def _print_shares(project: Project, folder: Path) -> None:
    """Of a session without a fault, and of one with a fault."""
    prepared(project, folder)
    causes.diagnose = _timed(DIAGNOSED, folder / COST)
    faults = (fault for fault in planted(project.name, project.map(folder)))
    print(f"{project.name}, without a fault: {_share(project, folder, None)}", flush=True)
    for fault in faults:
        share = _share(project, folder, fault)
        if share != NONE:
            print(f"{project.name}, {fault.id}: {share}", flush=True)
            return
    sys.exit(f"{project.name}: no planted fault makes a test fail")


NONE = "no diagnosis"


def _share(project: Project, folder: Path, fault: Fault | None) -> str:
    cost = folder / COST
    cost.unlink(missing_ok=True)
    began_s = _spent_s()
    ran(project, folder, fault)
    session_s = _spent_s() - began_s
    if not cost.is_file():
        return NONE
    diagnosis_s = float(cost.read_text())
    return f"{100.0 * diagnosis_s / (session_s - diagnosis_s):.1f} % of a session of {session_s - diagnosis_s:.1f} s"


def _spent_s() -> float:
    """Processor time (s) of this process and of those that have ended."""
    return sum(usage.ru_utime + usage.ru_stime for usage in map(getrusage, (RUSAGE_SELF, RUSAGE_CHILDREN)))


def _timed(diagnosed: Callable[..., Report], cost: Path) -> Callable[..., Report]:
    def timed(*arguments: Any) -> Report:
        began_s = _spent_s()
        report = diagnosed(*arguments)
        cost.write_text(str(_spent_s() - began_s))
        return report

    return timed


if __name__ == "__main__":
    main()
