"""Jobs done by a script that clicks: why it failed, what is not covered, what a change changed, can it be signed.

Seconds are those of the browser's work, which the script waits for: a person reads besides.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import pytest

from tests.report import sample_sections
from tests.report.test_behaviour_view import changed
from tests.report.test_page_navigation import with_parts
from tests.report.test_sheet import ORIGIN, PAGES_OF_PDF
from tests.report.watched import Watched

pytestmark = pytest.mark.slow


def failed_run() -> dict[str, Any]:
    """A report with causes, holes, a plan and an origin."""
    report = with_parts() | {"origin": ORIGIN, "rerun_options": {"suite": "rl", "options": []}}
    return report | {"closing": sample_sections.CLOSING}


MOST_S = 10.0
"""What a job may take: many times what it does here, as a machine may be busy."""


class Clicks:
    """Clicks on what can be seen, counted, and the seconds (s) since the first one could be made."""

    def __init__(self, page: Any) -> None:
        self.page, self.count, self.began_s = page, 0, time.monotonic()

    @property
    def seconds(self) -> float:
        """How long the job took so far."""
        return time.monotonic() - self.began_s

    def on(self, selector: str, text: str = "") -> None:
        """The first visible element that matches."""
        self.page.locator(f"{selector}:visible", has_text=text).first.click()
        self.count += 1


def test_the_cause_and_the_place_of_a_failure_take_at_most_three_clicks(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(failed_run(), tmp_path)
    clicks = Clicks(page)
    assert "controller/states.py:42" in page.locator("#summary .cause").first.inner_text()
    clicks.on("#summary .cause a", "Cause 1")
    page.wait_for_selector("#causes:not([hidden])")
    assert "<b>without</b> the disturbance it passes" in page.locator("#causes").inner_text()
    clicks.on("#causes a", "rl-one")
    page.wait_for_selector("#test:not([hidden]) svg")
    assert clicks.count <= 3
    assert clicks.seconds < MOST_S
    watched.assert_quiet()


def test_the_largest_hole_and_the_command_that_aims_at_it_take_two_clicks(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(failed_run(), tmp_path)
    clicks = Clicks(page)
    clicks.on("header nav a", "Coverage")
    clicks.on("#closure .hole summary")
    hole = page.locator("#closure .hole").first
    assert hole.locator(".command pre").first.inner_text().startswith("pytest ")
    assert hole.locator("tbody tr").first.is_visible()
    assert clicks.count == 2
    assert clicks.seconds < MOST_S
    watched.assert_quiet()


def test_what_is_not_covered_is_chosen_by_its_kind_and_leads_to_its_line(watched: Watched, tmp_path: Path) -> None:
    report = failed_run()
    gap = {"kind": "statements", "location": "controller/states.py Robot.move", "items": ["7"], "reason": "so"}
    report["closure"]["gaps"] += [gap | {"suggestion": "", "test": "", "beliefs": []}]
    page = watched.open(report, tmp_path, "closure")
    choice = page.get_by_label("Kind of what is not covered")
    other = choice.locator("option").last.get_attribute("value") or ""
    choice.select_option(other)
    shown = page.locator("#closure .hole:visible")
    assert {hole.get_attribute("data-group") for hole in shown.all()} == {other} != {"code"}
    choice.select_option("code")
    shown.first.locator("summary").click()
    link = shown.first.locator("tbody a").first
    link.click()
    page.wait_for_selector("#code:not([hidden])")
    assert page.locator("#code .source .current td").first.inner_text() == "7"
    watched.assert_quiet()


def test_what_a_change_changed_takes_two_clicks(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(changed(), tmp_path)
    clicks = Clicks(page)
    clicks.on("#summary a", "behave differently from the baseline")
    page.wait_for_selector("#tests:not([hidden])")
    clicks.on("#tests td a")
    page.wait_for_selector("#test:not([hidden]) svg")
    assert "First difference: at" in page.locator("#test").inner_text()
    assert clicks.count == 2
    assert clicks.seconds < MOST_S
    watched.assert_quiet()


def test_the_sheet_is_one_pdf_of_at_most_four_pages(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(failed_run(), tmp_path)
    clicks = Clicks(page)
    clicks.on("header nav a", "Sheet")
    page.wait_for_selector("#sheet:not([hidden])")
    pdf = page.pdf(path=tmp_path / "sheet.pdf", format="A4", prefer_css_page_size=True)
    assert 1 <= len(PAGES_OF_PDF.findall(pdf)) <= 4
    assert clicks.count == 1
