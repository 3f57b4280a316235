"""How fast the BDI engines are, side by side, and that their cost is linear. Prints tables of medians.

    python -m benchmarks.bdi_engine [--repeat N]

All is measured twice: with the engines' inner modules compiled, as they are installed from a wheel, which is built
first (a minute), and as plain Python, as in a checkout. Run it on an otherwise idle machine; nothing else may use its
cores.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from zipfile import ZipFile

from benchmarks.engine_times import COUNTS
from studies.session import machine

ROOT = Path(__file__).parents[1]
PEERS = """  for comparison, with the original models of the same task, not measured here:
  python-agentspeak 0.2.2                          5.0    ms
  Jason 1.4.2, in a warm JVM                      64      ms
  Jason 1.4.2, from process start to last line   810      ms"""
RUNS = {
    "interpreter, a run with four legs": "interpreter",
    "compiled, a run with four legs": "compiled",
    "memo, cold, mean of the runs of learning": "memo, cold",
    "memo, warm, mean of the runs of learning": "memo, warm",
}

Times = dict[str, float]
"""Seconds by the names of what was measured."""


def main() -> None:
    """Build the wheel, measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeat", type=int, default=5, metavar="N", help="runs of each measurement (default 5)")
    repeat = parser.parse_args().repeat
    print(f"machine: {machine()}\nmedians of {repeat}, microsecond-long ones of {200 * repeat}\n", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        build(Path(folder))
        both = [times(Path(folder), repeat), times(ROOT, repeat)]
    print(f"{'':46}  installed   plain Python")
    for name, what in (("table", "the table model"), ("spinning", "the same task by agents that look again and again")):
        print(what)
        for row, key in RUNS.items():
            show(f"  {row}", (each[f"{name}, {key}"] for each in both), 1e3, "ms")
        if name == "table":
            print(PEERS)
    show("all of learning: import, parse, compile, learn", (each["learning"] for each in both), 1, "s ")
    print("a reasoning cycle of an agent that counts")
    for rounds, agents in COUNTS:
        for engine in ("interpreter", "compiled"):
            what = f"  {rounds} rounds, {agents} agents, {engine}"
            show(what, (each[what.strip()] for each in both), 1e6, "us")


def build(folder: Path) -> None:
    """Build the wheel and unpack it.

    Raises:
        SystemExit: its engines are not compiled.
    """
    print("building the wheel ...", file=sys.stderr)
    command = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(folder), str(ROOT)]
    subprocess.run(command, check=True)
    (wheel,) = folder.glob("*.whl")
    if "none-any" in wheel.name:
        raise SystemExit(f"the engines were not compiled; to see why: pip wheel -v --no-deps {ROOT}")
    with ZipFile(wheel) as packed:
        packed.extractall(folder)


def times(package: Path, repeat: int) -> Times:
    """Measure the package in a folder."""
    print(f"measuring in {package} ...", file=sys.stderr)
    command = [sys.executable, "-m", "benchmarks.engine_times", "--repeat", str(repeat)]
    found = {"PYTHONPATH": f"{package}{os.pathsep}{ROOT}"}
    done = subprocess.run(command, cwd=package, env=os.environ | found, stdout=subprocess.PIPE, text=True, check=True)
    return {name: float(seconds) for name, seconds in (line.split("\t") for line in done.stdout.splitlines())}


def show(what: str, seconds: Iterable[float], unit: float, name: str) -> None:
    """Print a row of times."""
    print(f"{what:46}" + "".join(f"{each * unit:10.4f} {name}" for each in seconds), flush=True)


if __name__ == "__main__":
    main()
