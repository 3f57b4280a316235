"""Make the README's pictures from a real run: its report in a browser, and a failing test that moves.

    python -m studies.screenshots

Runs the learned suite once, with `--hri-strict`, so that known violations fail and their cause is looked for; and the
shortest failing test of the first cause again, with `--hri-film`. Needs Chromium; the environment variable CHROMIUM
gives its path if it is not found.
"""

from __future__ import annotations

import io
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from studies import freshness
from studies.moving_picture import moving_picture

PICTURES = Path(__file__).parents[1] / "docs" / "pictures"
SUITE = "--hri-suite=rl"
VIEWS = {"report.png": "", "tests.png": "tests", "closure.png": "closure", "sheet.png": "sheet"}
"""Picture -> the address of the view that it shows."""

WIDTH, HEIGHT = 1280, 840
COLOURS = 128
STILL = "() => [...document.querySelectorAll('#test video')].every(film => film.readyState > 1 && !film.seeking)"
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


def main() -> None:
    """Make the pictures."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        report = run(folder / "hri-report", "-n", "2", "--hri-strict")
        failing = report["causes"][0]["minimal_of"]
        filmed = run(folder / "filmed", "-k", failing, "--hri-film", "--hri-diagnose=8", "--hri-strict")
        (film,) = [test["film"]["video"] for test in filmed["tests"]]
        moving_picture(folder / "filmed" / film, PICTURES / "run.gif")
        for picture, view in VIEWS.items():
            screenshot(folder / "hri-report" / "index.html", PICTURES / picture, view)
        screenshot(folder / "filmed" / "index.html", PICTURES / "test.png", f"test/{failing}")
    freshness.made(["run.gif", "test.png", *VIEWS])


def run(folder: Path, *options: str) -> dict[str, Any]:
    """Run tests of the suite; returns their report."""
    command = [sys.executable, "-m", "pytest", SUITE, f"--hri-report={folder}", *options]
    ended = subprocess.run(command, check=False, stdout=subprocess.PIPE, text=True)
    if ended.returncode not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED):
        raise SystemExit(ended.stdout)
    loaded: dict[str, Any] = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    return loaded


def screenshot(page: Path, target: Path, address: str = "") -> None:
    """The top of a page's view with an address (empty: its first), as a window of WIDTH x HEIGHT shows it."""
    from playwright.sync_api import sync_playwright

    browser_path = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, BROWSERS)), None)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=browser_path, args=["--no-sandbox"])
        view = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT}, reduced_motion="reduce")
        view.goto(f"{page.as_uri()}#{address}" if address else page.as_uri())
        view.wait_for_selector("html[data-ready]", state="attached")
        if address.startswith("test/"):
            view.wait_for_selector("#test .timeline svg")
            view.wait_for_function(STILL)
        save(Image.open(io.BytesIO(view.screenshot())), target)
        browser.close()


def save(picture: Image.Image, target: Path) -> None:
    """Write a picture at most WIDTH pixels wide and with COLOURS colours, to keep the file small."""
    if picture.width > WIDTH:
        picture = picture.resize((WIDTH, round(picture.height * WIDTH / picture.width)), Image.Resampling.LANCZOS)
    target.parent.mkdir(exist_ok=True)
    picture.convert("RGB").quantize(COLOURS).save(target, optimize=True)
    print(f"{target}: {target.stat().st_size // 1024} KiB")


if __name__ == "__main__":
    main()
