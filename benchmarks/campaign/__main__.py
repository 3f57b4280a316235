"""A campaign: the abstract tests of one method, each concretized with many seeds, and run; resumed where it was left.

    python -m benchmarks.campaign [--state DIR] [--write]

It may be ended at any time, kill -9 included: at most the seed in the making is lost, and the same command goes on.
`--write` puts table and picture into docs/ when all seeds are done.
"""

from __future__ import annotations

import argparse
import shutil
import sys
from pathlib import Path

from benchmarks import session
from benchmarks.campaign import shard
from benchmarks.campaign.progress import Progress
from benchmarks.campaign.shard import Shard, ShardError
from benchmarks.campaign.state import Plan, State, StateError, depends

DEPENDS = (
    "conftest.py",
    "controller",
    "sim",
    "tests/hri/requirements.toml",
    "pytest_hricdv/case.py",
    "pytest_hricdv/cover",
    "pytest_hricdv/generate",
    "pytest_hricdv/monitor",
    "pytest_hricdv/runtime",
)
"""What a run's outcome depends on; the abstract tests, which the folder keeps, depend on the models besides."""


def main() -> None:
    """Run what is left, then say what came of all."""
    options = arguments().parse_args()
    try:
        shards = campaign(options)
    except (StateError, ShardError, session.SessionError) as error:
        sys.exit(f"campaign: {error}")
    except KeyboardInterrupt:
        sys.exit("campaign: interrupted; the same command goes on")
    del shards


def arguments() -> argparse.ArgumentParser:
    """The options."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--state", type=Path, default=Path("hri-campaign"), metavar="DIR", help="where shards are kept")
    parser.add_argument("--suite", default="rl", metavar="NAME", help="the method (default rl)")
    parser.add_argument(
        "--seed", type=int, default=0, metavar="N", help="abstract tests are generated from (default 0)"
    )
    parser.add_argument("--tests", type=positive, default=160, metavar="N", help="abstract tests (default 160)")
    parser.add_argument("--seeds", type=positive, default=41, metavar="N", help="seeds of each (default 41)")
    parser.add_argument("--workers", type=positive, default=2, metavar="N", help="xdist workers (default 2)")
    parser.add_argument("--root", type=Path, default=session.ROOT, metavar="DIR", help="the project")
    parser.add_argument("--depends", nargs="+", default=DEPENDS, metavar="PATH", help="what runs of it depend on")
    parser.add_argument("--write", action="store_true", help="put table and picture into docs/")
    return parser


def positive(text: str) -> int:
    """A whole number of at least 1. Raises argparse.ArgumentTypeError."""
    if not (text.isascii() and text.isdigit() and int(text) >= 1):
        raise argparse.ArgumentTypeError(f"{text!r}: expected a whole number, at least 1")
    return int(text)


def campaign(options: argparse.Namespace) -> tuple[Shard, ...]:
    """Run the seeds that are not done; the shards of all.

    Raises:
        StateError, ShardError: the folder is of another campaign, damaged, or in use.
        SessionError: pytest did not run the tests.
    """
    root, state = options.root.resolve(), State(options.state.resolve())
    with state.held():
        plan = Plan(options.suite, options.seed, options.tests, depends(root, options.depends))
        state.agree(plan)
        if state.tests() is None:
            state.keep_tests(generate(options.suite, options.seed, options.tests, state.work, root))
        tests = state.tests() or ()
        left = [seed for seed in range(options.seeds) if seed not in state.done()]
        progress = Progress(options.seeds, len(left), len(tests))
        for seed in left:
            made = shard.run(seed, tests, plan.identity, state.work, root, options.workers)
            state.keep(made)
            shutil.rmtree(state.work)
            progress.done(made)
        return tuple(state.shard(seed) for seed in range(options.seeds))


def generate(suite: str, seed: int, count: int, work: Path, root: Path) -> str:
    """The abstract tests, as pytest exports them."""
    folder = work / "export"
    chosen = [f"--hri-suite={suite}", f"--hri-seed={seed}", f"--hri-tests={count}"]
    session.start([*chosen, f"--hri-export={folder}", "--collect-only", "-p", "no:xdist"], root)
    (file,) = folder.glob("*.txt")
    return file.read_text(encoding="utf-8")


if __name__ == "__main__":
    main()
