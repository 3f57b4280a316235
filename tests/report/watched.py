"""A page in a browser, watched."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pytest_hricdv.report.files import write
from pytest_hricdv.results.model import Report
from tests.report import sample


class Watched:
    """A page, and every error, message and request of it."""

    def __init__(self, browser: Any, **options: Any) -> None:
        context = browser.new_context(offline=True, reduced_motion="reduce", **options)
        context.set_default_timeout(20_000)
        self.page = context.new_page()
        self.errors: list[str] = []
        self.requests: list[str] = []
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", lambda message: self.errors.append(message.text))
        self.page.on("dialog", lambda dialog: self.errors.append(f"dialog: {dialog.message}"))
        self.page.on("request", lambda request: self.requests.append(request.url))

    def open(self, report: dict[str, Any] | Report, folder: Path, view: str = "summary") -> Any:
        """Write the report, open its page at a view, and wait until it is ready."""
        write(report if isinstance(report, Report) else sample.typed(report), folder)
        self.page.goto(f"file://{folder}/index.html#{view}")
        self.page.wait_for_selector("html[data-ready]", state="attached")
        return self.page

    def open_test(self, report: dict[str, Any], folder: Path, address: str = "") -> Any:
        """Open the page of a test, by its address or the first one of the table; its run is drawn when this returns."""
        page = self.open(report, folder, address or "tests")
        if not address:
            page.locator("#tests td a").first.click()
        page.wait_for_selector("#test .timeline svg")
        return page

    def show(self, view: str) -> None:
        """Go to another view of the page; its plots are drawn when this returns."""
        self.page.evaluate("view => { location.hash = view; }", view)
        self.page.wait_for_function(
            "view => document.querySelector(`.view:not([hidden])`).id === view.split('/')[0] || "
            "document.querySelector(`.view:not([hidden])`).id === view",
            arg=view,
        )
        self.page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def assert_quiet(self) -> None:
        """Fail where there was an error or a message, or a request for anything but files beside the page."""
        assert self.errors == []
        assert [url for url in self.requests if not url.startswith(("file:", "data:", "blob:"))] == []


def listed(page: Any) -> Any:
    """The ids of the tests that the table lists; to be waited for, as a link shows it only when its click is over."""
    from playwright.sync_api import expect

    return expect(page.locator("#tests td:first-child a"))
