"""What fails on the unchanged controller: all suites over many seeds, for docs/studies/false-alarms.md.

    python -m studies.false_alarms [--suites NAME,...] [--seeds 0-9] [--report DIR] [--again] [--write]

A session for each suite and seed, of half a minute each. Each leaves its report in a folder of DIR (default
hri-false-alarms); one that is there and of the present code is not run again: end the command at any time, and start it
anew. The figures are printed; `--write` writes the page. `--again` runs none.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

from pytest_hricdv.results.codec import ReportError
from studies import grid, page, session
from studies.dependencies import DependencyError
from studies.false_alarms.alarms import Found, found_in
from studies.false_alarms.tables import context


def main() -> None:
    """Run what is missing; print the figures, and write them if asked to."""
    parser = session.arguments(__doc__, "hri-false-alarms")
    grid.add_options(parser, seeds="0-9")
    parser.add_argument("--write", action="store_true", help="write the page")
    options = parser.parse_args()
    try:
        sessions = run(grid.cells(options.suites, options.seeds), options.report.resolve(), again=options.again)
    except (session.SessionError, ReportError, DependencyError) as error:
        sys.exit(f"false alarms: {error}")
    except KeyboardInterrupt:
        sys.exit("false alarms: interrupted; start it again to go on")
    text = page.render("false_alarms/false_alarms.md.jinja", context(sessions))
    print(text)
    if options.write:
        page.write(options.docs / "studies" / "false-alarms.md", text)
        print(f"written: {options.docs / 'studies' / 'false-alarms.md'}")


def run(cells: Iterable[grid.Cell], folder: Path, *, again: bool) -> list[Found]:
    """What each session found; those whose reports are missing are run, unless `again`.

    Raises:
        SessionError: a session did not run its tests, or there is none.
        ReportError: a report is damaged.
        DependencyError: a file of the repository is missing.
    """
    sessions = []
    for cell, report in grid.reports(cells, folder, again=again):
        if report is None:
            print(f"{cell}: no report of the present code", flush=True)
            continue
        sessions.append(found_in(cell.suite, cell.seed, report))
        print(f"{cell}: {sessions[-1].runs} runs, {len(sessions[-1].alarms)} false alarms", flush=True)
    if not sessions:
        raise session.SessionError(f"{folder}: no session is of the present code; leave out --again")
    return sessions


if __name__ == "__main__":
    main()
