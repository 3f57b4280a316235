"""How many faults in the controller each suite notices: all mutants, with each suite and seed, for docs/adequacy.md.

    python -m studies.adequacy [--suites NAME,...] [--seeds N,...] [--faults N] [--tests N|all] [--report DIR] [--again]

A session for each suite and seed, of ten minutes or more. Each leaves its report in a folder of DIR (default
hri-adequacy); one that is there, complete and of the present code, is not run again: end the command at any time, and
start it anew. The page is written after each session, and says which ones it is made of. `--again` runs none.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import conftest
from pytest_hricdv.coverage.code_map import map_code
from pytest_hricdv.results.codec import ReportError, load
from pytest_hricdv.results.model import Report
from studies import page, session
from studies.adequacy.tables import Done, context

SUITES = "rl,by-hand,bdi-random,pseudorandom"
SEEDS = "0,1,2"
WORKERS = 2


@dataclass(frozen=True)
class Cell:
    """A session: a suite at a seed.

    Args:
        faults: so many mutants; None: all.
        tests: a mutant is tried on at most so many tests; None: on all that execute it.
    """

    suite: str
    seed: int
    faults: int | None
    tests: int | None

    def folder(self, parent: Path) -> Path:
        """Of its report."""
        return parent / f"{self.suite}-{self.seed}"

    @property
    def arguments(self) -> list[str]:
        """Of pytest."""
        drawn = [] if self.faults is None else [f"--hri-mutate-faults={self.faults}"]
        tests = f"--hri-mutate-tests={'all' if self.tests is None else self.tests}"
        return [
            f"--hri-suite={self.suite}",
            f"--hri-seed={self.seed}",
            "--hri-mutate",
            tests,
            *drawn,
            "-n",
            f"{WORKERS}",
        ]

    def is_of(self, report: Report, code_sha256: str) -> bool:
        """Whether a report is of this session, complete, and of the present code."""
        found = report.mutation
        if found is None or found.ended != "done" or report.code_under_test.sha256 != code_sha256:
            return False
        drawn = found.made if self.faults is None else min(self.faults, found.made)
        return (len(found.mutants), found.tests_per_mutant, found.seed) == (drawn, self.tests, self.seed)


def main() -> None:
    """Run what is missing; write the page after each session."""
    parser = session.arguments(__doc__, "hri-adequacy")
    parser.add_argument("--suites", default=SUITES, metavar="NAME,...")
    parser.add_argument("--seeds", default=SEEDS, metavar="N,...")
    parser.add_argument("--faults", type=int, metavar="N", help="only so many mutants, drawn with each seed")
    parser.add_argument("--tests", default="10", metavar="N|all", help="try a mutant on so many tests (10)")
    options = parser.parse_args()
    tests = None if options.tests == "all" else int(options.tests)
    cells = [
        Cell(suite, int(seed), options.faults, tests)
        for seed in options.seeds.split(",")
        for suite in options.suites.split(",")
    ]
    try:
        run(cells, options.report.resolve(), options.docs, again=options.again)
    except (session.SessionError, ReportError) as error:
        sys.exit(f"adequacy: {error}")
    except KeyboardInterrupt:
        sys.exit("adequacy: interrupted; start it again to go on")


def run(cells: Iterable[Cell], folder: Path, docs: Path, *, again: bool) -> None:
    """Run the sessions whose reports are missing, unless `again`, and write the page.

    Raises:
        SessionError: a session did not run its tests or try its mutants, or reports do not belong together.
        ReportError: a report is damaged.
    """
    code = conftest.pytest_hricdv_testbench(None).code  # type: ignore[arg-type]
    code_sha256 = map_code(code, session.ROOT).sha256
    done: list[Done] = []
    missing = []
    for cell in cells:
        report = _report(cell, folder, code_sha256)
        if report is None and not again:
            print(f"pytest {' '.join(cell.arguments)} ...", flush=True)
            session.run(cell.folder(folder), cell.arguments)
            report = _report(cell, folder, code_sha256)
            if report is None:
                raise session.SessionError(f"{cell.folder(folder)}: no mutants were tried; run it by hand to see why")
        if report is None:
            missing.append(f"{cell.suite} at seed {cell.seed}")
            continue
        done.append(Done(cell.suite, cell.seed, report))
        _write(done, docs)
    if not done:
        raise session.SessionError(f"{folder}: no session is complete and of the present code; leave out --again")
    print(
        f"written: {docs / 'adequacy.md'}, of {len(done)} sessions{', without ' if missing else ''}{', '.join(missing)}"
    )


def _report(cell: Cell, folder: Path, code_sha256: str) -> Report | None:
    if not (cell.folder(folder) / "report.json").is_file():
        return None
    report = load(cell.folder(folder))
    return report if cell.is_of(report, code_sha256) else None


def _write(done: list[Done], docs: Path) -> None:
    for each in done:
        if each.report.requirements != done[0].report.requirements:
            raise session.SessionError(
                f"{each.suite}-{each.seed} and {done[0].suite}-{done[0].seed} were judged by other requirements: "
                "remove the older folder, and it is run again"
            )
    page.write(docs / "adequacy.md", page.render("adequacy/adequacy.md.jinja", context(done)))


if __name__ == "__main__":
    main()
