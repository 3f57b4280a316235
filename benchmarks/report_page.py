"""Cost of the HTML report: time to write it, bytes, and time until it can be used in Chromium.

    python -m benchmarks.report_page [REPORT] [--tests N] [--repeat N]

REPORT is a real report.json (default hri-report/report.json). Its tests are repeated under new names until there are N
(7,000), and the report is completed like that of a session. The page is then opened from disk: it is ready when its
scripts have run and the first frame is painted; other times are from the click to the next frame. Needs the dependency
group `test`, and Chromium.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import sys
import tempfile
import time
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
    "the table of all tests": ("#tests", "#test-table tbody tr"),
    "a requirement's plots": ("#requirement/R3", "[id='requirement/R3'] figure:last-child svg"),
    "the suites' plots": ("#suites", "#suites figure svg"),
}


def main() -> None:
    """Enlarge a report, write it, open it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("report", nargs="?", type=Path, default=Path("hri-report"))
    parser.add_argument("--tests", type=int, default=7000)
    parser.add_argument("--repeat", type=int, default=5)
    options = parser.parse_args()
    report = grown(load(options.report), options.tests)
    print(f"{machine()}; {len(report.tests)} tests grown from {options.report}")
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        paths = write(report, Path(folder))
        print(f"written in            {time.perf_counter() - began:6.2f} s")
        for name, of in (("report.json", paths[:1]), ("index.html", paths[-1:]), ("details beside it", paths[1:-1])):
            print(f"{name:18} {sum(path.stat().st_size for path in of) / 1e6:9.2f} MB in {len(of)} files")
        timings = [opened(Path(folder)) for _ in range(options.repeat)]
        for view in timings[0]:
            times_s = [timing[view] for timing in timings]
            print(f"{view:24} {statistics.median(times_s):5.2f} s ({min(times_s):.2f} to {max(times_s):.2f})")


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


def opened(folder: Path) -> dict[str, float]:
    """Seconds until the page, and the views that are clicked, are visible."""
    from playwright.sync_api import sync_playwright

    path = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, BROWSERS)), None)
    timings = {}
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=QUIET)
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        page.goto("about:blank")
        began = time.perf_counter()
        page.goto(f"file://{folder}/index.html", wait_until="commit")
        page.wait_for_selector("html[data-ready]", state="attached")
        page.evaluate(PAINTED)
        timings["index ready"] = time.perf_counter() - began
        for view, (address, sign) in STEPS.items():
            timings[view] = _clicked(page, f"location.hash = {json.dumps(address)}", sign)
        timings["sorted by a column"] = _clicked(
            page,
            "location.hash = '#tests'; document.querySelector('#tests th:last-child button').click()",
            "#tests th[aria-sort]",
        )
        link = "document.querySelector('#test-table td a').click()"
        timings["the page of a test"] = _clicked(page, link, "#test .timeline svg")
        browser.close()
    return timings


def _clicked(page: Any, script: str, sign: str) -> float:
    began = time.perf_counter()
    page.evaluate(script)
    page.wait_for_selector(sign, state="attached")
    page.evaluate(PAINTED)
    return time.perf_counter() - began


if __name__ == "__main__":
    main()
