"""Commands on reports: `hricdv report triage`."""

from __future__ import annotations

import argparse
from pathlib import Path

from pytest_hricdv._base.message import harmless_line
from pytest_hricdv.report.view import ReportCommand
from pytest_hricdv.results.codec import ReportError, load

OK, FAILED = 0, 1


def _add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("report", type=Path, metavar="REPORT", help="a report folder or its report.json")


def _triage(options: argparse.Namespace) -> int:
    from pytest_hricdv.extra.diagnosis.records import DIAGNOSIS
    from pytest_hricdv.extra.diagnosis.triage import lines, proposals

    report = load(options.report)
    diagnosis = DIAGNOSIS.of(report)
    if diagnosis is None:
        if any(test.fails for test in report.tests):
            raise ReportError(f"{options.report}: no causes in it; run the suite again without --hri-diagnose=0")
        print("no test fails: nothing to tolerate")
        return OK
    made = proposals(report, diagnosis)
    for line in lines(report, made):
        print(harmless_line(line))
    return OK if all(entry.line for proposal in made for entry in proposal.entries) else FAILED


COMMANDS = (
    ReportCommand(
        "triage",
        "propose an entry of hri_known_violations for each cause; exit 1 where no condition separates one",
        _add_arguments,
        _triage,
    ),
)
