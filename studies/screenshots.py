"""Make the README's pictures from a real run: its report in a browser, and a film strip.

    python -m studies.screenshots

Runs the learned suite once, and one of its failing tests again with `--hri-film`. Needs Chromium; the environment
variable CHROMIUM gives its path if it is not found.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from PIL import Image

PICTURES = Path(__file__).parents[1] / "docs" / "pictures"
SUITE = "--hri-suite=rl"
WIDTH, HEIGHT = 1280, 840
COLOURS = 128
BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


def main() -> None:
    """Make both pictures."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        report = run(folder / "all", "-n", "2")
        failing = min((test for test in report["tests"] if test["outcome"] == "known-violation"), key=_margin)
        filmed = run(folder / "filmed", "-k", failing["id"], "--hri-film")
        (strip,) = [test["film"]["strip"] for test in filmed["tests"]]
        save(Image.open(folder / "filmed" / strip), PICTURES / "run.png")
        shot = folder / "report.png"
        screenshot(folder / "all" / "index.html", shot)
        save(Image.open(shot), PICTURES / "report.png")


def run(folder: Path, *options: str) -> dict[str, Any]:
    """Run tests of the suite; returns their report."""
    subprocess.run([sys.executable, "-m", "pytest", SUITE, f"--hri-report={folder}", *options], check=True)
    loaded: dict[str, Any] = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    return loaded


def screenshot(page: Path, target: Path) -> None:
    """The top of a page, as a window of WIDTH x HEIGHT shows it."""
    from playwright.sync_api import sync_playwright

    browser_path = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, BROWSERS)), None)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=browser_path, args=["--no-sandbox"])
        view = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT}, reduced_motion="reduce")
        view.goto(page.as_uri())
        view.wait_for_selector("html[data-ready]", state="attached")
        view.screenshot(path=target)
        browser.close()


def save(picture: Image.Image, target: Path) -> None:
    """Write a picture at most WIDTH pixels wide and with COLOURS colours, to keep the file small."""
    if picture.width > WIDTH:
        picture = picture.resize((WIDTH, round(picture.height * WIDTH / picture.width)), Image.Resampling.LANCZOS)
    target.parent.mkdir(exist_ok=True)
    picture.convert("RGB").quantize(COLOURS).save(target, optimize=True)
    print(f"{target}: {target.stat().st_size // 1024} KiB")


def _margin(test: dict[str, Any]) -> float:
    return min(verdict["margin"] or 0.0 for verdict in test["requirements"].values())


if __name__ == "__main__":
    main()
