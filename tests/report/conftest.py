"""A browser for the tests of the page."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from tests.report.watched import Watched

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


@pytest.fixture(scope="package")
def browser() -> Iterator[Any]:
    """Chromium for all tests of the page."""
    with chromium() as launched:
        yield launched


@contextmanager
def chromium() -> Iterator[Any]:
    """Chromium without a head: the machine's own, or the one that playwright has installed.

    Until it is closed, the process has a running event loop.
    """
    from playwright import sync_api  # takes long to load

    executable = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
    with started(sync_api.sync_playwright()) as playwright:
        quiet = ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update"]
        try:
            browser = playwright.chromium.launch(executable_path=executable, args=quiet)
        except sync_api.Error as error:
            pytest.skip(
                f"no Chromium: install one (Debian: apt install chromium) or set CHROMIUM ({error.message:.80})"
            )
        yield browser
        browser.close()


@contextmanager
def started(driver: Any) -> Iterator[Any]:
    """Playwright, whose driver is a program that does not run everywhere."""
    try:
        playwright = driver.__enter__()
    except Exception as error:  # a plain one, where the system lacks what the driver needs
        pytest.skip(f"playwright does not run here: {error}")
    try:
        yield playwright
    finally:
        driver.__exit__(None, None, None)


@pytest.fixture
def watched(browser: Any) -> Iterator[Watched]:
    """A page as wide as a desk's screen."""
    watched_page = Watched(browser, viewport={"width": 1280, "height": 900})
    yield watched_page
    watched_page.page.context.close()
