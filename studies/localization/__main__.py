"""Study: how often diagnosis points at planted faults and mutants (docs/studies/localization.md).

    python -m studies.localization [--projects NAME,...] [--mutants N] [--tests N] [--seed N] [--diagnose N]
                                   [--half even|odd] [--report DIR] [--again] [--write]

A session for each fault, in a copy of the testbench: a few seconds of processor time each. What was tried with the
present diagnosis is not tried again: end the command at any time, and start it anew. Mutants are drawn with the seed;
the first ones of more are the same. The figures are printed; `--write` writes them to the page, where those with a
`--diagnose` have a block of their own. `--again` tries none. `--half` takes the planted
faults at even or odd positions of their list: what is changed for one half is measured on the other.
"""

from __future__ import annotations

import sys
from pathlib import Path

from studies import page, session
from studies.localization import tables
from studies.localization.faults import HALVES, Drawn, FaultError
from studies.localization.measuring import Measured, measured
from studies.localization.projects import HELD_OUT, PROJECTS
from studies.localization.ranking import FIRST

COMMAND = "python -m studies.localization"


def main() -> None:
    """Try what was not tried; print the figures, and write them if asked to."""
    defaults = [project.name for project in PROJECTS]
    names = [*defaults, *(project.name for project in HELD_OUT)]
    parser = session.arguments(__doc__, "hri-localization")
    parser.add_argument("--projects", default=",".join(defaults), metavar="NAME,...", help=f"of {', '.join(names)}")
    parser.add_argument("--mutants", type=int, default=20, metavar="N", help="of each testbench (20)")
    parser.add_argument("--tests", type=int, default=30, metavar="N", help="of each session, at most (30)")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="that mutants are drawn with (0)")
    parser.add_argument("--diagnose", type=int, metavar="N", help="runs that a diagnosis may take (its default)")
    parser.add_argument("--half", choices=HALVES, help="of the planted faults: those at even or odd positions")
    parser.add_argument("--write", action="store_true", help="write the figures to the page")
    options = parser.parse_args()
    chosen = options.projects.split(",")
    if unknown := [name for name in chosen if name not in names]:
        parser.error(f"--projects: {unknown[0]!r}: expected one of {', '.join(names)}")
    pytest_options = [f"--hri-tests={options.tests}"]
    pytest_options += [] if options.diagnose is None else [f"--hri-diagnose={options.diagnose}"]
    done: list[Measured] = []
    try:
        for project in (*PROJECTS, *HELD_OUT):
            if project.name in chosen:
                folder: Path = options.report.resolve()
                for fault in measured(
                    project,
                    folder,
                    Drawn(options.seed, options.mutants, options.half),
                    tuple(pytest_options),
                    again=options.again,
                ):
                    done.append(fault)
                    print(f"{project.name}: {fault.fault}, {fault.kind}: {_said(fault)}", flush=True)
    except (session.SessionError, FaultError) as error:
        sys.exit(f"localization: {error}")
    except KeyboardInterrupt:
        sys.exit("localization: interrupted; start it again to go on")
    if not any(fault.hits for fault in done):
        sys.exit("localization: no fault that was tried makes a test fail")
    text = tables.text(done, options.diagnose)
    print(text)
    if options.write:
        command = COMMAND if options.diagnose is None else f"{COMMAND} --diagnose {options.diagnose}"
        page.replace_figures(options.docs / "studies" / "localization.md", command, text)
        print(f"written: {options.docs / 'studies' / 'localization.md'}")


def _said(fault: Measured) -> str:
    if not fault.hits:
        return "no test fails"
    hit = fault.hits["diagnosis"]
    return f"function {'first' if hit.function else 'not first'}, statement {_rank(hit.statements)}"


def _rank(shares: tuple[float, ...]) -> str:
    ranks = (f"among the first {most}" for most, share in zip(FIRST, shares, strict=True) if share)
    return next(ranks, "not there")


if __name__ == "__main__":
    main()
