"""``python -m pytest_hricdv.bdi``: run a BDI model from the command line."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from .errors import BdiError
from .system import MAX_ROUNDS, MultiAgentSystem

_EXAMPLES = """\
examples:
  python -m pytest_hricdv.bdi run hello.mas2j
  python -m pytest_hricdv.bdi run hello.mas2j --max-rounds 500 --seed 7

A project file names its agents; each has its AgentSpeak source beside it:

  hello.mas2j:   MAS hello { agents: ann; bob; }
  ann.asl:       !start.
                 +!start <- .print("hello"); .send(bob, tell, hello).
  bob.asl:       +hello[source(A)] <- .print("hello, ", A).

What the agents print goes to the standard output as '[agent] text'; how the run ended, warnings
and errors go to the standard error. The exit code is 0, or 2 if the model cannot be loaded or run.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    options = _parser().parse_args(arguments)
    try:
        system = MultiAgentSystem.load(options.file)
        result = system.run(max_rounds=options.max_rounds, seed=options.seed)
    except BdiError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    for line in result.prints:
        print(line)
    if options.quiet:
        return 0
    sys.stdout.flush()
    for warning in (*system.warnings, *result.warnings):
        print(f"warning: {warning}", file=sys.stderr)
    print(f"ended after {result.rounds} rounds: {result.ended}", file=sys.stderr)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m pytest_hricdv.bdi",
        description="Run multi-agent systems written in AgentSpeak, as Jason runs them but deterministically.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    run = commands.add_parser(
        "run",
        help="run a project and print what its agents print",
        description="Run a project and print what its agents print.",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    run.add_argument("file", metavar="FILE.mas2j", help="the project file")
    run.add_argument(
        "--max-rounds",
        type=_rounds,
        default=MAX_ROUNDS,
        metavar="N",
        help="stop after N rounds, one reasoning cycle of every agent each (default: %(default)s)",
    )
    run.add_argument("--seed", type=int, default=0, metavar="N", help="of the agents' random numbers (default: 0)")
    run.add_argument("--quiet", action="store_true", help="nothing but errors on the standard error")
    return parser


def _rounds(text: str) -> int:
    try:
        rounds = int(text)
    except ValueError:
        rounds = 0
    if rounds < 1:
        raise argparse.ArgumentTypeError(f"expected a number of rounds from 1, got {text!r}")
    return rounds


if __name__ == "__main__":
    sys.exit(main())
