"""Run each suite on both physics engines and say how far they agree, for docs/studies/engines.md.

    python -m studies.engines [--suites NAME,...] [--seeds 0] [--report DIR] [--again]

A session for each suite and seed with `--hri-engine=both`; each takes two minutes, and leaves its report in a folder of
DIR (default hri-engines); one that is there and of the present code is not run again. `--again` runs none.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

from pytest_hricdv.extra.engines.view import Agreement, agreement
from pytest_hricdv.results.codec import ReportError
from studies import grid, page, session
from studies.dependencies import DependencyError
from studies.engines.tables import context


def main() -> None:
    """Run what is missing; write the page."""
    parser = session.arguments(__doc__, "hri-engines")
    grid.add_options(parser, seeds="0")
    options = parser.parse_args()
    cells = grid.cells(options.suites, options.seeds, ("--hri-engine=both", "--hri-no-cov"))
    try:
        by_session = agreements(cells, options.report.resolve(), again=options.again)
    except (session.SessionError, ReportError, DependencyError) as error:
        sys.exit(f"engines: {error}")
    except KeyboardInterrupt:
        sys.exit("engines: interrupted; start it again to go on")
    page.write(options.docs / "studies" / "engines.md", page.render("engines/engines.md.jinja", context(by_session)))
    print(f"written: {options.docs / 'studies' / 'engines.md'}")


def agreements(cells: Iterable[grid.Cell], folder: Path, *, again: bool) -> dict[str, Agreement]:
    """Session -> how far the engines agree in it.

    Raises:
        SessionError: a session did not run its tests on two engines, or there is none.
        ReportError: a report is damaged.
        DependencyError: a file of the repository is missing.
    """
    by_session = {}
    for cell, report in grid.reports(cells, folder, again=again):
        agreed = agreement(report.tests) if report is not None else None
        if agreed is not None:
            by_session[str(cell)] = agreed
    if not by_session:
        raise session.SessionError(f"{folder} has no report of the present code with tests on two engines")
    return by_session


if __name__ == "__main__":
    main()
