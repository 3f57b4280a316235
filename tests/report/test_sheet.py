"""The sheet to sign: what is on it, and that it fits on four pages of paper."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.report import html
from pytest_hricdv.report.sheet import MAX_ROWS, sheet
from tests.report import sample, sample_sections, sample_tests
from tests.report.parsed import Page
from tests.report.watched import Watched

ORIGIN = {
    "began": "2026-11-26T08:15:37+00:00",
    "command": ["--hri-suite=rl"],
    "revision": "8961c2bf341f4a63aede41c232a15167b79cb0eb",
    "versions": {"python": "3.11.7"},
}
PAGES_OF_PDF = re.compile(rb"/Type\s*/Page\b(?!s)")


def large(requirements: int, goals: int = 30, waivers: int = 20) -> dict[str, Any]:
    """A report with texts that are as long as real ones."""
    report = sample.data(tests=10)
    title = "The robot shall neither move nor close its hand while a person is nearer than half a metre, whatever else"
    for number in range(requirements - len(sample_tests.TITLES)):
        report["requirements"][f"S{number}"] = {"title": f"{title} {number}", "source": "", "text": "", "group": "s"}
        for test in report["tests"]:
            test["requirements"][f"S{number}"] = sample_tests.requirement_result("Passed", 1.0)
    goal = sample_sections.PLAN[1] | {"title": title[:60]}
    report["plan"] = [
        sample_sections.PLAN[0] | {"goals": goals, "met": goals},
        *(goal | {"name": f"g{number}"} for number in range(goals)),
    ]
    for number in range(waivers):
        report["known_violations"][f"S{number}"] = f"{title[:70]} [safety team]"
    return report | {"origin": ORIGIN}


def test_the_sheet_has_plan_requirements_verdicts_waivers_owners_and_where_it_comes_from() -> None:
    report = sample.data(tests=8) | {"plan": sample_sections.PLAN, "origin": ORIGIN}
    report["known_violations"] = {"R3": "no crush prevention [safety team]"}
    report["known_until"] = {"R3": "2099-12-31"}
    text = html.page(sample.typed(report))[0]
    words = " ".join(Page(text).words.split()).partition("Verification of ")[2]
    for said in (
        "8961c2bf341f",
        "No crush ben failed R3 failed in 2 of 3 tests",
        "R4 The robot shall start and work in restricted joint speed passed 8 0 0 0",
        "R3 (known violation) no crush prevention safety team 2099-12-31",
        "controller/journal.py:60 (unreachable line) the port never closes in simulation nobody named no end needed",
        "pytest --hri-suite=rl , 2026-11-26 08:15:37 UTC",
        "Tested Reviewed Released",
    ):
        assert said in words
    assert "1 of 2 waivers name no owner" in words
    assert '@top-left { content: "table-assembly: verification by pytest-hricdv ' in text
    assert '@bottom-left { content: "revision 8961c2bf341f"' in text


def test_it_says_why_it_should_not_be_signed_yet() -> None:
    report = sample.data(tests=3)
    report |= {"reported": 2, "not_run": 1}
    report["code_under_test"] |= {"measured": False, "reason": "switched off"}
    said = "; ".join(sheet(sample.typed(report), (), ()).incomplete)
    assert "1 test not run or lost" in said
    assert "no revision of the project is known" in said
    assert "the code is unmeasured: switched off" in said


@pytest.mark.slow
@pytest.mark.parametrize("requirements", [4, 60, MAX_ROWS])
def test_the_sheet_is_printed_on_at_most_four_pages_in_the_light_theme(
    browser: Any, tmp_path: Path, requirements: int
) -> None:
    watched = Watched(browser, viewport={"width": 1280, "height": 900}, color_scheme="dark")
    page = watched.open(large(requirements, goals=8 if requirements == 4 else 30), tmp_path, "sheet")
    page.get_by_label("Theme").select_option("dark")
    pages = len(PAGES_OF_PDF.findall(page.pdf(format="A4", prefer_css_page_size=True)))
    assert 1 <= pages <= 4
    page.emulate_media(media="print")
    shade = page.evaluate("() => getComputedStyle(document.querySelector('#sheet h3')).color")
    assert sum(map(int, re.findall(r"\d+", shade))) < 200  # dark on white
    assert not page.locator("header").first.is_visible()
    watched.assert_quiet()
    page.context.close()
