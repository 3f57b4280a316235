"""`hricdv evidence`: documents what a report shows for each requirement, to be signed and archived, and verifies it.

    hricdv evidence hri-report -o evidence --requirements safety.reqif    # exit 1 if a requirement is open
    hricdv evidence verify evidence                                       # exit 1 if anything differs

`verify` checks all files and rows of evidence, and reruns a sample of its tests.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from pathlib import Path

from pytest_hricdv._base.message import InputError, harmless_line
from pytest_hricdv.results.codec import ReportError

OK, FAILED, USAGE = 0, 1, 2
PURPOSE = "document what the tests show for each requirement, to be signed and archived, or verify it"


def add_command(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command `evidence` to those of `hricdv`."""
    parser = commands.add_parser(
        "evidence", help=PURPOSE, description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.set_defaults(do=do)
    add = parser.add_argument
    add(
        "what", nargs="+", metavar="REPORT | verify DIR", help="a report folder or its report.json; or written evidence"
    )
    add("-o", "--output", type=Path, default=Path("evidence"), metavar="DIR", help="folder (default evidence)")
    add(
        "--requirements",
        type=Path,
        metavar="FILE",
        help="requirements with the ids of another tool: .reqif, .reqifz, .csv with a column id, or needs.json",
    )
    add("--project", type=Path, default=Path(), metavar="DIR", help="verify: where its tests run (default: here)")
    add("--rerun", type=int, default=3, metavar="N", help="verify: rerun N tests, compare records (default 3; 0: none)")


def do(options: argparse.Namespace) -> int:
    """Write or verify evidence; returns the exit status."""
    try:
        match options.what:
            case ["verify", folder]:
                return _verify(options, Path(folder))
            case [report] if report != "verify":
                return _write(options, Path(report))
            case _:
                raise InputError("expected a report, or `verify` and a folder that `evidence` wrote")
    except (ReportError, InputError) as error:
        print(harmless_line(f"error: evidence: {error}"), file=sys.stderr)
        return USAGE


def _write(options: argparse.Namespace, report: Path) -> int:
    from pytest_hricdv.extra.evidence.folder import write_evidence

    rows, problems = write_evidence(report, options.output, options.requirements)
    for problem in problems:
        print(harmless_line(f"problem: {problem}"))
    counts = Counter(row.status for row in rows)
    for row in rows:
        if row.is_open:
            print(harmless_line(f"{row.status}: {row.id} {row.title}"))
    print(f"{options.output}/index.html: " + ", ".join(f"{count} {status}" for status, count in counts.items()))
    return FAILED if problems or any(row.is_open for row in rows) else OK


def _verify(options: argparse.Namespace, folder: Path) -> int:
    from pytest_hricdv.extra.evidence.folder import verify_evidence

    problems = list(verify_evidence(folder, options.project, options.rerun))
    for problem in problems:
        print(harmless_line(f"FAILED {problem}"))
    if not problems:
        again = f", and {options.rerun} rerun tests gave the same records" if options.rerun else "; no test was rerun"
        print(f"{folder}: all files match the statement and the report{again}")
    return FAILED if problems else OK
