"""The documentation as a site: it builds without a warning, and a reader needs no network for it."""

from __future__ import annotations

import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest

from tests.docs.page import DOCS
from tests.docs.test_continuous_integration import environment

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `make docs` builds."""
    folder = tmp_path_factory.mktemp("site")
    options = ["--builder", "html", "--fail-on-warning", "--quiet", "--doctree-dir", str(folder / "trees")]
    command = [sys.executable, "-m", "sphinx", *options, str(DOCS), str(folder / "html")]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stdout + built.stderr
    return folder / "html"


class Quiet(SimpleHTTPRequestHandler):
    """Serves the site, and says nothing."""

    def log_message(self, format: str, *args: object) -> None:
        """Nothing."""


@pytest.fixture(scope="module")
def address(site: Path) -> Iterator[str]:
    """Where the site is served: a browser shows no excerpts of pages that it opens as files."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(site)))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}"
    server.shutdown()
    server.server_close()


@pytest.fixture(scope="module")
def window(browser: Any) -> Iterator[Any]:
    """A page of the browser."""
    opened = browser.new_page(viewport={"width": 1440, "height": 900})
    yield opened
    opened.close()


SEARCHES = {
    "flaky": "repeatability",
    "random numbers": "repeatability",
    "margin": "reading-the-report",
    "test my ROS node": "ros2",
    "ros": "ros2",
    "launch file": "ros2",
    "race condition": "schedules",
    "deadlock": "schedules",
    "github actions": "continuous-integration",
    "junit": "continuous-integration",
    "patch coverage": "continuous-integration",
    "resume": "interrupted-sessions",
    "mutation testing": "mutation",
    "simulator": "own-world",
    "lost message": "disturbances",
    "two people": "people",
    "install": "install",
    "tutorial": "tutorial",
    "requirement": "requirements",
    "known violation": "reference",
    "fixture": "reference",
    "exit code": "reference",
    "baseline": "behaviour-diff",
    "asyncio": "people",
    "threads": "bring-your-code",
    "AgentSpeak": "writing-models",
    "coverage closure": "suites",
    "q-learning": "suites",
    "rosbag": "traces",
    "why does my test fail": "diagnosis",
    "hypothesis": "comparison",
    "malicious": "trust",
    "dask": "campaigns",
    "iso 10218": "patterns",
    "sign off": "verification-plan",
    "existing code": "draft",
    "specification mining": "suggestions",
    "oracle": "model-as-oracle",
    "waits in real time": "troubleshooting",
}
"""What readers type -> the page that answers it, which has to come first."""


@pytest.mark.parametrize("words", SEARCHES)
def test_the_search_shows_the_page_that_answers_first(words: str, window: Any, address: str) -> None:
    window.goto(f"{address}/search.html?q={words.replace(' ', '+')}")
    window.wait_for_function("document.querySelector('.search-summary')?.innerText.includes('found')")
    first = window.locator("ul.search li a").first.get_attribute("href")
    assert Path(first.partition("?")[0].partition("#")[0]).stem == SEARCHES[words]


def test_the_search_leaves_studies_out(window: Any, address: str) -> None:
    window.goto(f"{address}/search.html?q=wilson")
    window.wait_for_function("document.querySelector('.search-summary')?.innerText")
    assert [link for link in window.locator("ul.search li a").all() if "studies/" in link.get_attribute("href")] == []


def test_the_site_is_built_with_its_dependency_group_alone(tmp_path: Path) -> None:
    programs = environment(tmp_path / "venv")
    for command in (
        ["pip", "install", "--quiet", "--upgrade", "pip>=25.1"],
        ["pip", "install", "--quiet", str(DOCS.parent), "--group", f"{DOCS.parent / 'pyproject.toml'}:docs"],
        ["sphinx", "--builder", "html", "--fail-on-warning", "--quiet", str(DOCS), str(tmp_path / "html")],
    ):
        done = subprocess.run([str(programs / "python"), "-m", *command], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr


def test_pages_load_nothing_from_elsewhere(site: Path) -> None:
    pages = [*site.rglob("*.html")]
    assert len(pages) > 50
    for page in pages:
        text = page.read_text(encoding="utf-8")
        assert re.findall(r"<(?:script|link|img|iframe)[^>]*(?:src|href)=\"(?:https?:)?//[^\"]*", text) == [], page
    for sheet in site.rglob("*.css"):
        assert "url(http" not in sheet.read_text(encoding="utf-8").replace('"', "").replace("'", ""), sheet


def test_each_public_name_is_in_the_index(site: Path) -> None:
    index = (site / "genindex.html").read_text(encoding="utf-8")
    for name in (
        "Testbench",
        "Uniform",
        "HriCase",
        "CaseResult",
        "parse_pattern",
        "MultiAgentSystem",
        "MessageDisturbance",
        "Value",
    ):
        assert re.search(rf">\s*{name}\b", index), name
