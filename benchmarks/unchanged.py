"""Are results still the same? Stores what every suite gives at seeds 0 and 1, or compares with what was stored.

    python -m benchmarks.unchanged store FILE
    python -m benchmarks.unchanged compare FILE [--suite=NAME ...] [--seed=N ...]

For a change that must not change results, such as a new structure: store first, compare at each step. Kept are the
whole `report.json` without its times, so ids, texts, verdicts, margins, hashes of records, bits of coverage, bins.
"""

from __future__ import annotations

import argparse
import gzip
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

SUITES = ("by-hand", "bdi-random", "rl", "pseudorandom", "closure")
SEEDS = (0, 1)  # 0 is the default, which users have; 1 shows what was written for 0
UNSTABLE = ("wall_s", "replay", "origin")
"""Keys of `report.json` that hold measured times, paths into the folder of the report, or when it was made."""


def report_of(suite: str, seed: int) -> Any:
    """The report of one suite, run on two workers, without what differs from run to run."""
    with tempfile.TemporaryDirectory() as folder:
        options = [f"--hri-suite={suite}", f"--hri-seed={seed}", f"--hri-report={folder}", "-n", "2", "-q"]
        # Verdicts decide about the exit code; what is compared is the report.
        subprocess.run([sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *options], capture_output=True)
        return stable(json.loads((Path(folder) / "report.json").read_text(encoding="utf-8")))


def read(file: Path) -> dict[str, dict[str, Any]]:
    """What was stored: suite and seed -> report."""
    reports = json.loads(gzip.decompress(file.read_bytes()))
    return {name: stable(report) for name, report in reports.items()}


def stable(value: Any) -> Any:
    """`value` without what differs from run to run."""
    if isinstance(value, dict):
        return {key: stable(item) for key, item in value.items() if key not in UNSTABLE}
    return [stable(item) for item in value] if isinstance(value, list) else value


def differences(stored: Any, now: Any, where: str = "") -> Iterator[str]:
    """Where two reports differ, a line each."""
    if isinstance(stored, dict) and isinstance(now, dict):
        for key in sorted(stored.keys() | now.keys()):
            yield from differences(stored.get(key), now.get(key), f"{where}.{key}")
    elif isinstance(stored, list) and isinstance(now, list) and len(stored) == len(now):
        for number, (before, after) in enumerate(zip(stored, now, strict=True)):
            yield from differences(before, after, f"{where}[{number}]")
    elif stored != now:
        yield f"{where}: {str(stored)[:100]} became {str(now)[:100]}"


def main() -> int:
    """Stores or compares; returns 1 where something differs."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.unchanged", description=__doc__)
    parser.add_argument("action", choices=("store", "compare"))
    parser.add_argument("file", type=Path, help="gzipped JSON")
    parser.add_argument("--suite", action="append", choices=SUITES, help="only these (repeatable)")
    parser.add_argument("--seed", action="append", type=int, help="only these (repeatable)")
    options = parser.parse_args()
    chosen = [(suite, seed) for seed in options.seed or SEEDS for suite in options.suite or SUITES]
    stored = {} if options.action == "store" else read(options.file)
    reports, faults = {}, 0
    for suite, seed in chosen:
        name = f"{suite} seed {seed}"
        reports[name] = report_of(suite, seed)
        lines = list(differences(stored.get(name, {}), reports[name])) if options.action == "compare" else []
        faults += len(lines)
        count = len(reports[name]["tests"])
        print(f"{name}: {count} tests, {len(lines)} differences", *lines[:20], sep="\n  ", flush=True)
    if options.action == "store":
        options.file.write_bytes(gzip.compress(json.dumps(reports, sort_keys=True).encode("ascii")))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
