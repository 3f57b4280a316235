"""Memory and time of a session with one long run, by the number of its events: the run, its record, journal and page.

    python -m benchmarks.long_runs [--events N ...] [--violating] [--page]

In the run of a small project, half of the events are messages and half are changes of a signal; every other message
triggers a requirement, which the next one meets. With `--violating`, none is met, so that a quarter of the events are
violations. Each session runs in a process of its own, whose peak memory is what the system says (Linux, macOS). With
`--page`, the page of the test is opened in Chromium as well.
"""

from __future__ import annotations

import argparse
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from benchmarks.report_page import BROWSERS, PAINTED, QUIET
from studies.session import machine
from tests.plugin.project import make_long, write

EVENTS = (1_000, 10_000, 100_000, 1_000_000)
FIRST = EVENTS[0]
"""What a session with so few events takes is subtracted: it is that of the session itself."""


@dataclass(frozen=True)
class Figures:
    """What a session took: CPU time (s), peak memory (bytes), bytes of the files in its report by kind, and the time
    until its test is drawn in a browser (s)."""

    cpu_s: float
    memory: int
    journal: int
    report: int
    page: int
    opened_s: float


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--events", type=int, nargs="+", default=EVENTS[1:], metavar="N")
    parser.add_argument("--violating", action="store_true", help="no trigger is met")
    parser.add_argument("--page", action="store_true", help="open the page of the test (needs the group `test`)")
    options = parser.parse_args()
    print(f"machine: {machine()}\nan event of a run, beyond a run with {FIRST:,} events:", flush=True)
    columns = ("session", 12), ("us", 8), ("memory", 12), ("bytes", 8), ("journal", 9), ("report", 8), ("page", 8)
    print(f"{'events':>10}" + "".join(f"{name:>{width}}" for name, width in columns) + "  page open")
    first = measured(FIRST, options.violating, False)
    for count in options.events:
        session, more = measured(count, options.violating, options.page), count - FIRST
        each = [
            (getattr(session, name) - getattr(first, name)) / more
            for name in ("cpu_s", "memory", "journal", "report", "page")
        ]
        print(
            f"{count:10,}{session.cpu_s:10.1f} s{each[0] * 1e6:8.1f}{session.memory / 1e6:9.0f} MB"
            f"{each[1]:8.0f}{each[2]:9.1f}{each[3]:8.1f}{each[4]:8.1f}"
            + (f"{session.opened_s:9.1f} s" if options.page else ""),
            flush=True,
        )


def measured(count: int, violating: bool, opens_page: bool) -> Figures:
    """A session with one run of so many events."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write(folder)
        make_long(folder, count // 2, is_met=not violating)
        process = subprocess.Popen(
            [
                sys.executable,
                "-m",
                "pytest",
                "-q",
                "--tb=no",
                "-p",
                "no:cacheprovider",
                "--hri-suite=by-hand",
                "--hri-tests=1",
            ],
            cwd=folder,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert process.stdout is not None
        output = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        cpu_s = usage.ru_utime + usage.ru_stime
        report = folder / "hri-report"
        if not (report / "report.json").is_file():
            sys.exit(f"{status}: {output}")
        unit = 1 if sys.platform == "darwin" else 1024
        pages = [path for path in report.rglob("*") if path.is_file() and path.suffix in (".html", ".js")]
        journal, results = ((report / name).stat().st_size for name in ("journal.jsonl", "report.json"))
        size = sum(path.stat().st_size for path in pages)
        shown_s = opened_s(report) if opens_page else 0.0
        return Figures(cpu_s, usage.ru_maxrss * unit, journal, results, size, shown_s)


def opened_s(report: Path) -> float:
    """The time until the timeline of the report's test is drawn (s)."""
    from playwright.sync_api import sync_playwright

    path = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, BROWSERS)), None)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=QUIET)
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        page.goto(f"file://{report}/index.html#tests")
        page.locator("#tests td a").first.wait_for()
        began_s = time.perf_counter()
        page.locator("#tests td a").first.click()
        page.wait_for_selector("#test .timeline svg", timeout=600_000)
        page.evaluate(PAINTED)
        browser.close()
        return time.perf_counter() - began_s


if __name__ == "__main__":
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    main()
