"""The page in a browser: how one gets from view to view, and back, with a mouse and with a keyboard."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.report import sample, sample_sections, sample_tests
from tests.report.watched import Watched


def with_parts(tests: int = 30) -> dict[str, Any]:
    """A report with a plan, causes and mutants."""
    report = sample.data(tests=tests)
    for test, name in zip(report["tests"], ("rl-one", "rl-two"), strict=False):
        test["id"] = name
    report |= {"mutation": sample_sections.MUTATION, "plan": sample_sections.PLAN, "causes": sample_sections.CAUSES}
    return report


@pytest.mark.slow
def test_each_view_has_a_title_and_the_keyboards_place_is_its_heading(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(with_parts(), tmp_path)
    first = page.title()
    assert first.endswith(" · table-assembly: pytest-hricdv report")
    titles = {first}
    links = page.evaluate("() => [...document.querySelectorAll('header nav a')].map((link) => link.hash.slice(1))")
    views = [view for view in dict.fromkeys(links) if view != "summary"]
    for view in [*views, "requirement/R3"]:
        watched.show(view)
        heading = page.locator(".view:not([hidden]) h2").first
        assert heading.evaluate("heading => heading === document.activeElement")
        titles.add(page.title())
    assert len(titles) == len(views) + 2
    assert "R3 The robot shall not close its hand when the human hand is too close · table-assembly" in page.title()
    watched.assert_quiet()


@pytest.mark.slow
def test_requirements_are_searched_and_the_address_keeps_it(watched: Watched, tmp_path: Path) -> None:
    report = sample.data(tests=30)
    for number in range(60):
        name = f"S{number}"
        report["requirements"][name] = {"title": f"Rule {number}", "source": "", "text": "", "group": "speed"}
        for test in report["tests"]:
            test["requirements"][name] = sample_tests.requirement_result("NC" if number == 7 else "Passed", 1.0)
    page = watched.open(report, tmp_path, "requirements")
    rows = page.locator("#requirements tr[data-state]:visible td:first-child a")
    assert rows.count() == 64
    page.get_by_label("Search requirements").fill("RULE S1")
    assert rows.all_inner_texts() == ["S1", *(f"S{number}" for number in range(10, 20))]
    assert page.locator("#requirements [data-shown]").inner_text() == "11 of 64"
    page.get_by_label("Search requirements").fill("")
    page.get_by_label("State").select_option("not checked")
    assert rows.all_inner_texts() == ["S7"]
    assert page.evaluate("location.hash") == "#requirements?state=not+checked"
    rows.first.click()
    page.wait_for_selector("[id='requirement/S7']:not([hidden])")
    page.go_back()
    page.wait_for_selector("#requirements:not([hidden])")
    assert rows.all_inner_texts() == ["S7"]
    watched.show("summary")
    page.locator("#summary a.badge", has_text="1 not checked").click()
    page.wait_for_selector("#requirements:not([hidden])")
    assert rows.all_inner_texts() == ["S7"]
    watched.assert_quiet()


def test_a_question_mark_lists_the_keys(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(with_parts(), tmp_path)
    page.keyboard.press("?")
    box = page.locator("dialog.keys")
    assert "search everything" in box.inner_text()
    page.keyboard.press("/")  # one dialog at a time
    assert page.locator("dialog[open]").count() == 1
    page.keyboard.press("Escape")
    page.keyboard.press("/")
    assert page.locator("dialog[open]").get_attribute("aria-label") == "Search"
    page.keyboard.type("?")
    assert page.locator("dialog[open]").count() == 1
    watched.assert_quiet()


def test_a_slash_searches_everything(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(with_parts(), tmp_path)
    page.keyboard.press("/")
    box = page.locator("dialog.search")
    for words, kind, address in (
        ("hand is too close", "requirement", "#requirement/R3"),
        ("cross products", "view", "#cross"),
        ("journal.py", "file", "#code/controller%2Fjournal.py"),
    ):
        box.locator("input").fill(words)
        hit = box.locator(".hits a", has_text=kind).first
        assert hit.get_attribute("href") == address
    box.locator("input").fill("hand is too close")
    page.keyboard.press("Enter")
    page.wait_for_selector("[id='requirement/R3']:not([hidden])")
    assert not box.is_visible()
    box_again = page.locator("button.find")
    box_again.click()
    box.locator("input").fill("xyzzy")
    assert "0 found" in box.inner_text()
    watched.assert_quiet()
