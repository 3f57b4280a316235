"""Cost of the HTML report: time to write it, bytes, and time until it can be used in Chromium.

    python -m benchmarks.report_page [REPORT] [--tests N] [--repeat N] [--beside FOLDER]

REPORT is a real report.json (default hri-report/report.json). Its tests are repeated under new names until there are N
(7,000), and the report is completed like that of a session. The page is then opened from disk: it is ready when its
scripts have run and the first frame is painted; other times are from the click to the next frame. With --beside, a
page of the same tests that another version wrote is opened in turn, and the ratios of the medians are printed: of
times, and of what the page's main thread worked, which hardly depends on what else the machine does. Needs the
dependency group `test`, and Chromium.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from msgspec.structs import replace

from pytest_hricdv.report.files import write
from pytest_hricdv.results.codec import load
from pytest_hricdv.results.derivation import derive
from pytest_hricdv.results.model import Report
from studies.session import machine

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
QUIET = ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update"]
PAINTED = "() => new Promise(done => requestAnimationFrame(() => setTimeout(done, 0)))"
STEPS = {
    "the table of all tests": ("location.hash = '#tests'", "#test-table tbody tr"),
    "a requirement's plots": ("location.hash = '#requirement/R3'", "[id='requirement/R3'] figure:last-child svg"),
    "the suites' plots": ("location.hash = '#suites'", "#suites figure svg"),
    "sorted by a column": (
        "location.hash = '#tests'; document.querySelector('#tests th:last-child button').click()",
        "#tests th[aria-sort]",
    ),
    "the page of a test": ("document.querySelector('#test-table td a').click()", "#test .timeline svg"),
}
"""View -> what opens it, and the element that it then has."""


@dataclass(frozen=True)
class Cost:
    """Until something is visible: the time (s), and for how long the page's main thread worked (s)."""

    time_s: float
    work_s: float


def main() -> None:
    """Enlarge a report, write it, open it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("report", nargs="?", type=Path, default=Path("hri-report"))
    parser.add_argument("--tests", type=int, default=7000)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--beside", type=Path, help="folder of a page of the same tests by another version")
    options = parser.parse_args()
    report = grown(load(options.report), options.tests)
    print(f"{machine()}; {len(report.tests)} tests grown from {options.report}")
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        paths = write(report, Path(folder))
        print(f"written in            {time.perf_counter() - began:6.2f} s")
        for name, of in (("report.json", paths[:1]), ("index.html", paths[-1:]), ("details beside it", paths[1:-1])):
            print(f"{name:18} {sum(path.stat().st_size for path in of) / 1e6:9.2f} MB in {len(of)} files")
        pages = [page for page in (Path(folder), options.beside) if page is not None]
        rounds = [[opened(page) for page in pages] for _ in range(options.repeat)]
        for view in rounds[0][0]:
            print(f"{view:24} {_figures([[timings[view] for timings in turn] for turn in rounds])}")


def _figures(rounds: list[list[Cost]]) -> str:
    """Medians (s) of the page with its least and most time; beside another page, the ratios to its medians."""
    ours = [turn[0] for turn in rounds]
    times_s = [cost.time_s for cost in ours]
    work_s = statistics.median(cost.work_s for cost in ours)
    text = f"{statistics.median(times_s):5.2f} s ({min(times_s):.2f} to {max(times_s):.2f}), works {work_s:5.2f} s"
    if len(rounds[0]) == 1:
        return text
    other = [turn[1] for turn in rounds]
    time_ratio = statistics.median(times_s) / statistics.median(cost.time_s for cost in other)
    return (
        f"{text}; {time_ratio:.2f} times, works {work_s / statistics.median(cost.work_s for cost in other):.2f} times"
    )


def grown(report: Report, count: int) -> Report:
    """The report with its tests repeated under new names until there are `count`."""
    tests = report.tests
    if not tests:
        sys.exit("the report has no tests to be repeated: run a suite first")
    more = []
    for number in range(count):
        test = tests[number % len(tests)]
        copy_of = f"x{number // len(tests):04d}-"
        more.append(replace(test, id=copy_of + test.id, nodeid=test.nodeid.replace("[", "[" + copy_of)))
    return derive(replace(report, tests=tuple(more)))


def opened(folder: Path) -> dict[str, Cost]:
    """What it costs until the page, and the views that are clicked, are visible."""
    from playwright.sync_api import sync_playwright

    path = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, BROWSERS)), None)
    costs = {}
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=QUIET)
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        devtools = page.context.new_cdp_session(page)
        devtools.send("Performance.enable", {"timeDomain": "threadTicks"})
        page.goto("about:blank")
        began, worked_s = time.perf_counter(), _worked_s(devtools)
        page.goto(f"file://{folder.absolute()}/index.html", wait_until="commit")
        page.wait_for_selector("html[data-ready]", state="attached")
        page.evaluate(PAINTED)
        costs["index ready"] = Cost(time.perf_counter() - began, max(0.0, _worked_s(devtools) - worked_s))
        for view, (script, sign) in STEPS.items():
            costs[view] = _clicked(page, devtools, script, sign)
        browser.close()
    return costs


def _clicked(page: Any, devtools: Any, script: str, sign: str) -> Cost:
    worked_s, began = _worked_s(devtools), time.perf_counter()
    page.evaluate(script)
    page.wait_for_selector(sign, state="attached")
    page.evaluate(PAINTED)
    return Cost(time.perf_counter() - began, _worked_s(devtools) - worked_s)


def _worked_s(devtools: Any) -> float:
    """Processor time of the tasks of the page's main thread until now (s)."""
    metrics = devtools.send("Performance.getMetrics")["metrics"]
    return float(next(metric["value"] for metric in metrics if metric["name"] == "TaskDuration"))


if __name__ == "__main__":
    main()
