"""What the journal costs of a suite's wall time: writing it once more, after a session that wrote it.

    python -m benchmarks.journal [--repeat N] [SUITE]

Runs the suite (default `by-hand`) on two workers, then appends every record of its journal to another one on the same
disk, and hashes the project's files again: all that a session does only for its journal.
"""

from __future__ import annotations

import argparse
import statistics
import tempfile
import time
from pathlib import Path

from pytest_hricdv.results.journal import NAME, JournalWriter, records
from pytest_hricdv.session.preparation import files_and_versions
from studies.session import ROOT, machine, run


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("suite", nargs="?", default="by-hand", metavar="SUITE")
    parser.add_argument("--repeat", type=int, default=5, metavar="N", help="times of writing (default 5)")
    options = parser.parse_args()
    print(f"machine: {machine()}", flush=True)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        session = run(folder, [f"--hri-suite={options.suite}", "-n", "2"])
        journal = folder / NAME
        times = [(hash_s(), write_s(journal, folder / "again.jsonl")) for _ in range(options.repeat)]
        size = journal.stat().st_size
    hashing, writing = (statistics.median(column) for column in zip(*times, strict=True))
    tests = session.report["reported"]
    print(f"{tests} tests in {session.wall_s:.1f} s, journal of {size / 1e6:.1f} MB")
    print(
        f"hashing files {1000 * hashing:.1f} ms, writing {1000 * writing:.1f} ms ({1000 * writing / tests:.3f} a test)"
    )
    print(f"together {100 * (hashing + writing) / session.wall_s:.3f} % of the wall time")


def hash_s() -> float:
    """The time of hashing the project's files (s)."""
    began_s = time.perf_counter()
    files_and_versions(ROOT)
    return time.perf_counter() - began_s


def write_s(journal: Path, again: Path) -> float:
    """The time of writing all records of a journal into another file (s), without that of reading them."""
    written = [*records(journal)]
    writer = JournalWriter(again)
    began_s = time.perf_counter()
    for record in written:
        writer.append(record)
    taken_s = time.perf_counter() - began_s
    writer.close()
    return taken_s


if __name__ == "__main__":
    main()
