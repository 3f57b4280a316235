"""The trend on the page: in which sessions a test failed."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.report import sample
from tests.report.watched import Watched


@pytest.mark.slow
def test_a_test_has_a_dot_for_each_complete_session(watched: Watched, tmp_path: Path) -> None:
    report = sample.data(tests=1)
    name = report["tests"][0]["id"]
    sessions = [([], True), ([name], True), ([], False), ([], True)]
    report["history"] = [
        {"began": "2026-01-02T03:04:05Z", "failing": failing, "complete": complete} for failing, complete in sessions
    ]
    page = watched.open_test(report, tmp_path)
    dots = page.locator("#test .dots")
    assert dots.inner_text().split() == ["●", "✗", "●"]
    assert dots.get_attribute("aria-label") == "failed in 1 of the last 3 complete sessions"
    watched.assert_quiet()
