"""Time of learning, collecting, the first test and all tests of the learned suite: a table of medians.

    python -m benchmarks.end_to_end [--repeat N]

Run it on an otherwise idle machine; nothing else may use its cores.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from studies.session import ROOT, machine


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--repeat", type=int, default=3, metavar="N", help="runs of each measurement (default 3)")
    repeat = parser.parse_args().repeat
    print(f"machine: {machine()}\nmedians of {repeat}\n")
    with tempfile.TemporaryDirectory() as folder:
        os.environ["PYTHONPYCACHEPREFIX"] = f"{folder}/bytecode"  # warm, and independent of earlier runs
        os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
        report = Path(folder) / "report"
        cache = ["-o", f"cache_dir={folder}/cache"]
        collect(["-p", "no:cacheprovider"])
        show("learning and collecting", repeat, lambda: collect(["-p", "no:cacheprovider"]))
        collect(cache)
        show("collecting a learned suite", repeat, lambda: collect(cache))
        first_test(report)  # writes the bytecode of what the runs above did not import
        show("from the command to the first test", repeat, lambda: first_test(report))
        options = [*cache, f"--hri-report={report}"]
        one_s = show("the learned suite on one worker", repeat, lambda: suite(1, options))
        two_s = show("the learned suite on two workers", repeat, lambda: suite(2, options))
        figures = json.loads((report / "report.json").read_text(encoding="utf-8"))
    simulated_s = sum(test["sim_s"] for test in figures["tests"])
    busy_s = sum(test["wall_s"] for test in figures["tests"])
    print(f"\ntests {figures['reported']}, simulated {simulated_s:.0f} s; two workers {one_s / two_s:.2f} x one")
    print(f"simulated seconds per second of one core, coverage and monitors included: {simulated_s / busy_s:.0f}")


def show(label: str, repeat: int, action: Callable[[], float | None]) -> float:
    """Print the median wall time (s) of an action, which may return the moment of its end; returns it."""
    times = []
    for _ in range(repeat):
        began = time.perf_counter()
        ended = action()
        times.append((ended or time.perf_counter()) - began)
    median_s = statistics.median(times)
    print(f"{label:34} {median_s:7.2f} s", flush=True)
    return median_s


def collect(options: list[str]) -> None:
    """Collect the learned suite without running it."""
    pytest(["--hri-suite=rl", "--collect-only", "-q", *options])


def first_test(report: Path) -> float:
    """Start the main job on two workers, learning included, and end it when the first test is running: that moment."""
    options = ["--hri-suite=rl", "-n", "2", "-v", "-p", "no:cacheprovider", f"--hri-report={report}"]
    with subprocess.Popen(
        [sys.executable, "-u", "-m", "pytest", *options],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        assert process.stdout is not None
        # The id of a running test is printed without a line's end, which comes when the test is over.
        output = ""
        try:
            while "::" not in output and (char := process.stdout.read(1)):
                output += char
            ended = time.perf_counter()
        finally:
            # The workers, too: they would finish their tests, and take processor time from the next measurement.
            os.killpg(process.pid, signal.SIGKILL)
    assert "::" in output, "pytest ended without a test"
    return ended


def suite(workers: int, options: list[str]) -> None:
    """Run the learned suite."""
    pytest(["--hri-suite=rl", "-n", str(workers), *options])


def pytest(arguments: list[str]) -> None:
    """Run pytest in a subprocess; a failure ends the benchmark with its output."""
    process = subprocess.run(
        [sys.executable, "-m", "pytest", *arguments], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if process.returncode:
        sys.exit(process.stdout + process.stderr)


if __name__ == "__main__":
    main()
