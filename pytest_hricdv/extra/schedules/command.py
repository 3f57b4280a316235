"""`hricdv budgets`: runs a session of pytest that measures time budgets, with `--hri-budgets`."""

from __future__ import annotations

import argparse
import subprocess
import sys

TESTS = 6
"""As in docs/schedules.md: enough to break most requirements, in a minute."""


def add_command(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Add the command `budgets` to those of `hricdv`."""
    purpose = "measure how slow each function and loop of the code may be until a requirement breaks"
    text = f"{purpose.capitalize()}: pytest --hri-budgets=N, with the arguments after --."
    parser = commands.add_parser("budgets", help=purpose, description=text)
    parser.add_argument(
        "--tests", type=int, default=TESTS, metavar="N", help=f"tests to measure with (default {TESTS})"
    )
    parser.add_argument("arguments", nargs="*", metavar="ARGUMENT", help="of pytest, as -- --hri-suite=rl")
    parser.set_defaults(do=_do)


def _do(options: argparse.Namespace) -> int:
    return subprocess.call([sys.executable, "-m", "pytest", f"--hri-budgets={options.tests}", *options.arguments])
