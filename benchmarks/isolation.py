"""What a process for each test costs, and the audit after the tests: processor time, as ratios to sessions without.

    python -m benchmarks.isolation [--repeat N] [--tests EXPRESSION] [--workers N ...]

Sessions of each kind take turns, so that what else the machine does meets all of them; processor time of a session is
that of all its processes. Ratios are medians of those within a turn.
"""

from __future__ import annotations

import argparse
import resource
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Sequence

from studies.session import ROOT, machine

KINDS = {
    "without": ("--hri-audit=off",),
    "with --hri-isolate": ("--hri-audit=off", "--hri-isolate"),
    "audited": (),
}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeat", type=int, default=5, metavar="N", help="turns (default 5)")
    parser.add_argument("--tests", default="", metavar="EXPRESSION", help="only tests of the suite rl that -k selects")
    parser.add_argument("--workers", type=int, nargs="*", default=[0, 2], help="of xdist (default 0 and 2)")
    arguments = parser.parse_args()
    print(f"machine: {machine()}\nmedians of {arguments.repeat}")
    with tempfile.TemporaryDirectory() as folder:
        common = ["--hri-suite=rl", "-q", f"--hri-report={folder}/report", "-o", f"cache_dir={folder}/cache"]
        common += ["-k", arguments.tests] if arguments.tests else []
        session(common)  # learns, and writes bytecode
        for workers in arguments.workers:
            turns = [
                {kind: session([*common, *options, f"-n{workers}"]) for kind, options in KINDS.items()}
                for _ in range(arguments.repeat)
            ]
            print(f"\n{f'{workers} workers' if workers else 'in one process'}")
            for kind in KINDS:
                ratio = statistics.median(turn[kind] / turn["without"] for turn in turns)
                median_s = statistics.median(turn[kind] for turn in turns)
                print(f"{kind:20} {median_s:8.2f} s of processor time  {ratio:6.3f} times", flush=True)


def session(options: Sequence[str]) -> float:
    """Run a session; returns the processor time (s) of all its processes."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-m", "pytest", *options], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return (after.ru_utime - before.ru_utime) + (after.ru_stime - before.ru_stime)


if __name__ == "__main__":
    main()
