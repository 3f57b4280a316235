"""How many faults in the controller each suite notices, by its mutants, for docs/studies/adequacy.md.

    python -m studies.adequacy [--suites NAME,...] [--seeds 0-2] [--mutants N] [--tests N|all] [--report DIR] [--again]

A session for each suite and seed, of ten minutes or more; with `--mutants=N`, all suites try the same N mutants at a
seed, drawn with it, and the page gives the intervals. Each session leaves its report in a folder of DIR (default
hri-adequacy); one that is there, complete and of the present code, is not run again: end the command at any time, and
start it anew. The page is written after each session, and says which ones it is made of. `--again` runs none.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from pathlib import Path

from pytest_hricdv.extra.mutation.records import MUTATION
from pytest_hricdv.results.codec import ReportError
from pytest_hricdv.results.model import Report
from studies import grid, page, session
from studies.adequacy.tables import Done, context
from studies.dependencies import DependencyError


def main() -> None:
    """Run what is missing; write the page after each session."""
    parser = session.arguments(__doc__, "hri-adequacy")
    grid.add_options(parser, seeds="0-2")
    parser.add_argument("--mutants", type=int, metavar="N", help="only so many mutants, drawn with each seed")
    parser.add_argument("--tests", default="10", metavar="N|all", help="try a mutant on so many tests (10)")
    options = parser.parse_args()
    try:
        cells = grid.cells(options.suites, options.seeds, mutating(options))
        run(cells, options.report.resolve(), options.docs, again=options.again)
    except (session.SessionError, ReportError, DependencyError) as error:
        sys.exit(f"adequacy: {error}")
    except KeyboardInterrupt:
        sys.exit("adequacy: interrupted; start it again to go on")


def mutating(options: argparse.Namespace) -> list[str]:
    """Options of pytest."""
    drawn = [] if options.mutants is None else [f"--hri-mutate-faults={options.mutants}"]
    return ["--hri-mutate", f"--hri-mutate-tests={options.tests}", *drawn]


def run(cells: Iterable[grid.Cell], folder: Path, docs: Path, *, again: bool) -> None:
    """Run the sessions whose reports are missing, unless `again`, and write the page.

    Raises:
        SessionError: a session did not run its tests or try its mutants.
        ReportError: a report is damaged.
        DependencyError: a file of the repository is missing.
    """
    done: list[Done] = []
    missing = []
    for cell, report in grid.reports(cells, folder, again=again, complete=_has_tried_all):
        if report is None:
            missing.append(str(cell))
            continue
        done.append(Done(cell.suite, cell.seed, report))
        page.write(docs / "studies" / "adequacy.md", page.render("adequacy/adequacy.md.jinja", context(done)))
    if not done:
        raise session.SessionError(f"{folder}: no session is complete and of the present code; leave out --again")
    left_out = f", without {', '.join(missing)}" if missing else ""
    print(f"written: {docs / 'studies' / 'adequacy.md'}, of {len(done)} sessions{left_out}")


def _has_tried_all(report: Report) -> bool:
    result = MUTATION.of(report)
    return result is not None and result.end_reason == "done"


if __name__ == "__main__":
    main()
