"""How fast suites reach points, and what each strategy of the closing loop contributes, for docs/studies/closure.md.

    python -m studies.closure [--suites NAME,...] [--without STRATEGY,...] [--seeds 0-9] [--runs N] [--again]
        [--report DIR]

A session for each suite and seed, and one of the loop for each strategy that is left out. The loop has 400 runs, the
other suites twice as many tests, as theirs are shorter. Each takes some minutes and leaves its report in a folder of
DIR (default hri-closure). A report of the present code is not run again: end the command at any time, and start it
again. The page and its picture are written after each session, from the sessions that are there; `--again` runs none.
A small version: `--seeds 0 --runs 48`.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from pytest_hricdv.extra.closing.records import CLOSING
from pytest_hricdv.results.codec import ReportError
from pytest_hricdv.results.model import Report
from studies import grid, page, plots, session
from studies.closure.growth import Growth, of_loop, of_suite
from studies.closure.tables import LOOP, WITHOUT, context, curves
from studies.dependencies import DependencyError

SUITES = (LOOP, *grid.SUITES)
STRATEGIES = ("model", "disturbances", "online")
SECONDS = 24 * 3600
"""No loop ends for want of time, or it would depend on the machine."""
MORE = 2
"""Times the runs of a loop: so many tests have the other suites, so that they last as long in simulated time."""


def main() -> None:
    """Run what is missing; write the page after each session."""
    parser = session.arguments(__doc__, "hri-closure")
    grid.add_options(parser, seeds="0-9", suites=SUITES)
    parser.add_argument(
        "--without",
        type=_strategies,
        default=STRATEGIES,
        metavar="STRATEGY,...",
        help=f"({','.join(STRATEGIES)}; or none)",
    )
    parser.add_argument("--runs", type=int, default=400, metavar="N", help="of a loop (400)")
    options = parser.parse_args()
    try:
        cells = sessions(options.suites, options.without, options.seeds, options.runs)
        run(cells, options.report.resolve(), options.docs, again=options.again)
    except (session.SessionError, ReportError, DependencyError) as error:
        sys.exit(f"closure: {error}")
    except KeyboardInterrupt:
        sys.exit("closure: interrupted; start it again to go on")


def _strategies(text: str) -> tuple[str, ...]:
    names = () if text == "none" else tuple(text.split(","))
    unknown = [name for name in names if name not in STRATEGIES]
    if unknown:
        raise argparse.ArgumentTypeError(f"{unknown[0]!r}: expected none, or some of {', '.join(STRATEGIES)}")
    return names


def sessions(suites: Iterable[str], strategies: Sequence[str], seeds: Iterable[int], runs: int) -> list[grid.Cell]:
    """The sessions, seed by seed: the loop first, as it says which points there are."""
    # How fast points are reached: what is searched for afterwards has no part in it.
    closing = (f"--hri-close-runs={runs}", f"--hri-close-seconds={SECONDS}", "--hri-close-search=0")
    others = [suite for suite in suites if suite != LOOP]
    cells = []
    for seed in seeds:
        cells.append(grid.Cell(LOOP, seed, closing))
        cells += [grid.Cell(suite, seed, (f"--hri-tests={MORE * runs}",)) for suite in others]
        cells += [
            grid.Cell(LOOP, seed, (*closing, f"--hri-close-without={strategy}"), WITHOUT + strategy)
            for strategy in strategies
        ]
    return cells


def run(cells: Iterable[grid.Cell], folder: Path, docs: Path, *, again: bool) -> None:
    """Run the sessions whose reports are missing, unless `again`, and write the page and its picture.

    Raises:
        SessionError: a session did not run its tests, or there is none of the whole loop.
        ReportError: a report is damaged.
        DependencyError: a file of the repository is missing.
    """
    done: list[Growth] = []
    missing = []
    for cell, report in grid.reports(cells, folder, again=again, complete=_is_complete):
        if report is None:
            missing.append(str(cell))
            continue
        done.append((of_loop if cell.suite == LOOP else of_suite)(cell.name, cell.seed, report))
        if any(growth.series == LOOP for growth in done):
            write(done, report, docs)
    if not any(growth.series == LOOP for growth in done):
        raise session.SessionError(f"{folder}: no session of {LOOP} is complete and of the present code")
    left = f"; missing: {', '.join(missing)}" if missing else ""
    print(f"written: {docs / 'studies' / 'closure.md'}, of {len(done)} sessions{left}")


def write(done: Sequence[Growth], report: Report, docs: Path) -> None:
    """The page and its picture."""
    page.write(docs / "studies" / "closure.md", page.render("closure/closure.md.jinja", context(done, report)))
    made, axes = plots.figure(panels=2)
    for panel, (title, kind) in zip(axes, (("all points", ""), ("bins of cross products", "bin")), strict=True):
        plots.curves(panel, curves(done, kind), x="simulated time (s)", y="points hit (%)", drawn="steps-post")
        panel.set_title(title)
    plots.save(made, docs / "pictures" / "closure.svg")


def _is_complete(report: Report) -> bool:
    result = CLOSING.of(report)
    return result is None or result.end_reason not in ("seconds", "interrupted")


if __name__ == "__main__":
    main()
