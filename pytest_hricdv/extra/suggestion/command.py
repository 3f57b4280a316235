"""`hricdv suggest`: a session of pytest that suggests requirements.

    hricdv suggest                      # of the suite in pytest.ini, or of --suite=rl
    hricdv suggest --most=20 --faults=50

It runs the suite, records its runs and those of tests with other parameters, and mines what all of them satisfied. This
is ranked by the seeded bugs that violate it and that no requirement notices (this needs the extra `mutation`;
without it, or with --faults=0, by how much it excludes). Each suggestion is four lines to paste into the file of
requirements: read the title, ask whether the robot *has to* do what it did, and only then add

    accepted_by = "your name"
    accepted_on = 2026-11-26

What all runs do may be what all runs do wrong. Until both lines are there, each session says that nobody has accepted
it. Runs are kept in the folder suggestions/ of the report, so an interrupted command resumes.
"""

from __future__ import annotations

import argparse
import subprocess
import sys

from pytest_hricdv.extra.suggestion.options import SuggestionOptions

PURPOSE = "suggest requirements that all runs of a suite satisfied, with what each rests on"


def add_command(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command `suggest` to those of `hricdv`."""
    parser = commands.add_parser("suggest", help=PURPOSE, description=__doc__)
    parser.set_defaults(do=do)
    add, default = parser.add_argument, SuggestionOptions()
    add(
        "--suite",
        metavar="NAME|PATH[,...]",
        help="as --hri-suite of pytest (default: what the project's ini file says)",
    )
    add("--seed", type=int, default=0, metavar="N", help="seed of suite, further tests and bugs (default 0)")
    add("--tests", type=_number, metavar="N", help="tests of each suite (default: the method's own)")
    add("--most", type=_number, default=default.most, metavar="N", help=f"suggestions (default {default.most})")
    add("--faults", type=_number, default=default.faults, metavar="N", help=f"seeded bugs (default {default.faults})")
    add(
        "--further",
        type=_number,
        default=default.further,
        metavar="N",
        help=f"further tests, with other parameters (default {default.further})",
    )
    add("--seconds", type=_number, metavar="S", help="start no new bug after S seconds (default: no limit)")
    add("--anew", action="store_true", help="ignore existing requirements, to compare suggestions with them")
    add("pytest", nargs="*", metavar="ARGUMENT", help="further arguments of pytest, after --, as -- -n 2")


def pytest_arguments(options: argparse.Namespace) -> list[str]:
    """What pytest is called with."""
    made = ["--hri-suggest", f"--hri-seed={options.seed}"]
    made += [f"--hri-suite={options.suite}"] if options.suite else []
    made += [f"--hri-tests={options.tests}"] if options.tests else []
    for name in ("most", "faults", "further"):
        made.append(f"--hri-suggest-{name}={getattr(options, name)}")
    made += [f"--hri-suggest-seconds={options.seconds}"] if options.seconds else []
    made += ["--hri-suggest-anew"] if options.anew else []
    return [*made, *options.pytest]


def do(options: argparse.Namespace) -> int:
    """Run pytest with them, in a process of its own; returns its exit status."""
    try:
        return subprocess.run([sys.executable, "-m", "pytest", *pytest_arguments(options)], check=False).returncode
    except KeyboardInterrupt:  # pytest has got it, too, and has said so
        return 2


def _number(text: str) -> int:
    if not (text.isascii() and text.isdigit()):
        raise argparse.ArgumentTypeError(f"{text!r}: expected a whole number")
    return int(text)
