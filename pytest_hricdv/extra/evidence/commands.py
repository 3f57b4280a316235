"""Commands on reports: `python -m pytest_hricdv.report evidence` and `verify`."""

from __future__ import annotations

import argparse
from collections import Counter
from pathlib import Path

from pytest_hricdv._base.message import harmless_line
from pytest_hricdv.report.view import ReportCommand

OK, FAILED = 0, 1


def _add_evidence(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("report", type=Path, metavar="REPORT", help="a report folder or its report.json")
    add("-o", "--output", type=Path, default=Path("evidence"), metavar="DIR", help="folder (default evidence)")
    add(
        "--requirements",
        type=Path,
        metavar="FILE",
        help="requirements with the ids of another tool: .reqif, .csv with a column id, or needs.json",
    )


def _write(options: argparse.Namespace) -> int:
    from pytest_hricdv.extra.evidence.folder import write_evidence

    rows, problems = write_evidence(options.report, options.output, options.requirements)
    for problem in problems:
        print(harmless_line(f"problem: {problem}"))
    counts = Counter(row.status for row in rows)
    for row in rows:
        if row.is_open:
            print(harmless_line(f"{row.status}: {row.id} {row.title}"))
    print(f"{options.output}/index.html: " + ", ".join(f"{count} {status}" for status, count in counts.items()))
    return FAILED if problems or any(row.is_open for row in rows) else OK


def _add_verify(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("folder", type=Path, metavar="DIR", help="a folder that `evidence` wrote")
    add("--project", type=Path, default=Path(), metavar="DIR", help="where its tests run (default: here)")
    add("--rerun", type=int, default=3, metavar="N", help="rerun N tests, compare their records (default 3; 0: none)")


def _verify(options: argparse.Namespace) -> int:
    from pytest_hricdv.extra.evidence.folder import verify_evidence

    problems = list(verify_evidence(options.folder, options.project, options.rerun))
    for problem in problems:
        print(harmless_line(f"FAILED {problem}"))
    if not problems:
        again = f", and {options.rerun} tests came out the same" if options.rerun else "; no test was run again"
        print(f"{options.folder}: the files are those of the statement and of the report{again}")
    return FAILED if problems else OK


COMMANDS = (
    ReportCommand(
        "evidence",
        "write what the tests show for each requirement, to be signed and kept; exit 1 where one is open",
        _add_evidence,
        _write,
    ),
    ReportCommand(
        "verify",
        "check evidence: its files, its rows, and a sample of its tests run again; exit 1 where one differs",
        _add_verify,
        _verify,
    ),
)
