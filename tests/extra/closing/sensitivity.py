"""How much a constant of the loop matters: loops on many scenes, with other values of it.

    python -m tests.extra.closing.sensitivity [--scenes N] [--seeds N] [--runs N] [MODULE.NAME VALUE...]

For each value: the share of targets that are open on the way, averaged over the runs of a loop (the less, the sooner
targets are hit), its difference from what the present value gives (mean and 95 % interval over loops of the same scene
and seed), the share that is open at the end, and how many loops closed. Without a constant: the present values alone.
"""

from __future__ import annotations

import argparse
import importlib
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from statistics import fmean, stdev
from typing import NamedTuple

from tests.extra.closing.scenes import Scene

PACKAGE = "pytest_hricdv.extra.closing"


class Growth(NamedTuple):
    """How a loop went: the share of targets open on average and at the end, and whether it closed."""

    average: float
    left: float
    closed: bool


def growth(constant: str, value: str, scene: int, seed: int, runs: int) -> Growth:
    """A loop with a value of a constant; without one, if its name is empty."""
    if constant:
        module, _, name = constant.rpartition(".")
        owner = importlib.import_module(f"{PACKAGE}.{module}")
        present = getattr(owner, name)
        setattr(owner, name, type(present)(value))
    try:
        loop = Scene(scene).loop(seed, runs)
        ended = loop.run()
    finally:
        if constant:
            setattr(owner, name, present)
    left, total = len(loop.archive.targets), 0
    for entry in loop.archive.entries:
        left -= len(entry.new)
        total += left
    size = len(loop.archive.targets)
    return Growth(total / size / runs, len(loop.archive.open) / size, ended == "closed")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("constant", nargs="?", default="", help="for instance disturbance_way.EXPLORING")
    parser.add_argument("values", nargs="*")
    parser.add_argument("--scenes", type=int, default=10)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--runs", type=int, default=160)
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    pairs = [*product(range(options.scenes), range(options.seeds))]
    with ProcessPoolExecutor(options.processes) as pool:
        jobs = {
            value: [
                pool.submit(growth, options.constant if value else "", value, scene, seed, options.runs)
                for scene, seed in pairs
            ]
            for value in ("", *options.values)
        }
        results = {value: [job.result() for job in submitted] for value, submitted in jobs.items()}
    for value, loops in results.items():
        print(row(value, loops, results[""]), flush=True)


def row(value: str, loops: Sequence[Growth], present: Sequence[Growth]) -> str:
    """A line of the table."""
    differences = [100.0 * (loop.average - other.average) for loop, other in zip(loops, present, strict=True)]
    half = 1.96 * stdev(differences) / len(differences) ** 0.5
    shares = f"open on average {100.0 * fmean(loop.average for loop in loops):.1f} %"
    difference = f" ({fmean(differences):+.1f} +- {half:.1f})" if value else ""
    left = f"{100.0 * fmean(loop.left for loop in loops):.1f} % at the end"
    return f"{value or 'present':8} {shares}{difference}, {left}, closed {sum(loop.closed for loop in loops)}"


if __name__ == "__main__":
    main()
