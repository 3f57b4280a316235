"""A campaign: run the abstract tests of one method, each concretized with many seeds; resumable.

    python -m benchmarks.campaign [--state DIR] [--write]

It may be stopped at any time, even by kill -9: only the unfinished seed is lost, and the same command resumes. The
results are written to DIR/results.md; `--write` also writes page and chart to docs/. `--again` runs no tests: it writes
the results of the finished seeds, even if the code has changed since.
"""

from __future__ import annotations

import argparse
import hashlib
import shutil
import sys
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path

from benchmarks.campaign import results, shard, totals
from benchmarks.campaign.progress import Progress
from benchmarks.campaign.shard import Shard, ShardError
from benchmarks.campaign.state import DIGITS, Plan, State, StateError
from pytest_hricdv.results.gates import KNOWN, parse_exemptions
from studies import page, plots, session
from studies.dependencies import DEPENDS, DependencyError, depends
from studies.session import machine


def main() -> None:
    """Run the unfinished seeds, then write the results of all."""
    options = arguments().parse_args()
    try:
        shards = collected(options) if options.again else campaign(options)
        plan = State(options.state.resolve()).plan()
    except (StateError, ShardError, DependencyError, session.SessionError) as error:
        sys.exit(f"campaign: {error}")
    except KeyboardInterrupt:
        sys.exit("campaign: interrupted; the same command resumes it")
    known = known_violations(options.root)
    page.write(options.state / "results.md", results.text(shards, list(known)))
    print(f"written: {options.state / 'results.md'}")
    if options.write:
        write(plan, shards, known, options.docs)
        print(f"written: {options.docs / 'campaign.md'}")


def arguments() -> argparse.ArgumentParser:
    """The options."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--state", type=Path, default=Path("hri-campaign"), metavar="DIR", help="folder of the shards")
    parser.add_argument("--suite", default="rl", metavar="NAME", help="the method (default rl)")
    parser.add_argument(
        "--seed", type=int, default=0, metavar="N", help="abstract tests are generated from (default 0)"
    )
    parser.add_argument("--tests", type=positive, default=160, metavar="N", help="abstract tests (default 160)")
    parser.add_argument("--seeds", type=positive, default=41, metavar="N", help="seeds of each (default 41)")
    parser.add_argument("--workers", type=positive, default=2, metavar="N", help="xdist workers (default 2)")
    parser.add_argument("--root", type=Path, default=session.ROOT, metavar="DIR", help="the project")
    parser.add_argument("--depends", nargs="+", default=DEPENDS, metavar="PATH", help="files that runs depend on")
    parser.add_argument("--again", action="store_true", help="run no tests: use the finished seeds")
    parser.add_argument("--write", action="store_true", help="write page and chart to docs/")
    parser.add_argument("--docs", type=Path, default=session.ROOT / "docs", metavar="DIR", help="the page's folder")
    return parser


def positive(text: str) -> int:
    """A whole number of at least 1. Raises argparse.ArgumentTypeError."""
    if not (text.isascii() and text.isdigit() and int(text) >= 1):
        raise argparse.ArgumentTypeError(f"{text!r}: expected a whole number, at least 1")
    return int(text)


def campaign(options: argparse.Namespace) -> tuple[Shard, ...]:
    """Run the unfinished seeds; returns the shards of all seeds.

    Raises:
        StateError, ShardError: the folder belongs to another campaign, is damaged, or is in use.
        DependencyError: a file that runs depend on is missing.
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


def collected(options: argparse.Namespace) -> tuple[Shard, ...]:
    """The finished shards. Raises StateError if there are none; see `campaign`."""
    state = State(options.state.resolve())
    done = state.done()
    if not done:
        raise StateError(f"{state.folder}: no seed is done there: leave out --again to run them")
    return tuple(state.shard(seed) for seed in done)


def generate(suite: str, seed: int, count: int, work: Path, root: Path) -> str:
    """The abstract tests, as pytest exports them."""
    folder = work / "export"
    chosen = [f"--hri-suite={suite}", f"--hri-seed={seed}", f"--hri-tests={count}"]
    session.start([*chosen, f"--hri-export={folder}", "--collect-only", "-p", "no:xdist"], root)
    (file,) = folder.glob("*.txt")
    return file.read_text(encoding="utf-8")


def known_violations(root: Path) -> dict[str, str]:
    """Known violations of the project: requirement -> reason."""
    path = root / "pyproject.toml"
    if not path.is_file():
        return {}
    pytest = tomllib.loads(path.read_text(encoding="utf-8")).get("tool", {}).get("pytest", {})
    lines = pytest.get("ini_options", {}).get("hri_known_violations", [])
    return {name: each.reason for name, each in parse_exemptions(lines, KNOWN).items()}


def write(plan: Plan, shards: Sequence[Shard], known: Mapping[str, str], docs: Path) -> None:
    """Write page and chart."""
    requirements = totals.requirements(shards)
    worst = max(requirements, key=lambda each: each.failed)
    plots.save(results.picture(shards, worst.name), docs / "pictures" / "campaign-seeds.svg")
    files = {name: text for name, text in plan.depends.items() if len(text) == DIGITS}
    context = {
        "plan": plan,
        "tests": len(shards[0].runs),
        "seeds": len(shards),
        "runs": sum(len(shard.runs) for shard in shards),
        "example": shards[-1].runs[0].id,
        "results": results.text(shards, list(known)),
        "requirements": requirements,
        "alike": round(len(shards[0].runs) * (1 - (1 - (worst.rate.value if worst.rate else 0.0)) ** len(shards))),
        "known": known,
        "cpu_s": sum(shard.cpu_s for shard in shards),
        "wall_s": sum(shard.wall_s for shard in shards),
        "machine": machine(),
        "hashes": summed(files),
        "versions": {name: text for name, text in plan.depends.items() if name not in files},
    }
    page.write(docs / "campaign.md", page.render("campaign.md.jinja", context, Path(__file__).parent))


def summed(files: Mapping[str, str]) -> dict[str, str]:
    """One hash for each folder at the top, and for each file there."""
    grouped: dict[str, list[str]] = {}
    for name in sorted(files):
        top, slash, _ = name.partition("/")
        grouped.setdefault(top + slash, []).append(f"{name} {files[name]}\n")
    return {name: hashlib.sha256("".join(lines).encode("utf-8")).hexdigest() for name, lines in grouped.items()}


if __name__ == "__main__":
    main()
