"""The page in a browser: the table of tests, and what leads to them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.report import sample
from tests.report.watched import Watched, listed


@pytest.mark.slow
def test_the_table_of_tests_is_sorted_and_searched(watched: Watched, tmp_path: Path) -> None:
    report = sample.data(("by-hand", "rl"), 80)
    page = watched.open(report, tmp_path, "tests")
    names = [test["id"] for test in report["tests"]]
    ascending = [test["id"] for test in sorted(report["tests"], key=lambda test: test["sim_s"])]
    drawn = page.locator("#tests tbody td.id a")
    assert drawn.all_inner_texts() == names[: drawn.count()]
    page.get_by_role("button", name="Simulated").click()
    assert drawn.all_inner_texts() == ascending[: drawn.count()]
    page.get_by_role("button", name="Simulated").click()
    assert drawn.all_inner_texts() == ascending[::-1][: drawn.count()]
    assert page.locator("#tests th[aria-sort=descending]").inner_text().strip() == "Simulated"

    page.get_by_role("searchbox").fill("RL leg4")
    matching = [name for name in ascending[::-1] if name.startswith("rl-leg4")]
    listed(page).to_have_text(matching)
    page.get_by_label("Outcome").select_option("failed")
    failed = {test["id"] for test in report["tests"] if test["outcome"] == "failed"}
    listed(page).to_have_text([name for name in matching if name in failed])
    page.get_by_role("searchbox").fill("no such test")
    listed(page).to_have_count(0)
    assert "0 of 160 tests" in page.locator("#shown").inner_text()
    watched.assert_quiet()


@pytest.mark.slow
def test_a_table_of_very_many_tests_has_only_those_in_sight_and_scrolls(watched: Watched, tmp_path: Path) -> None:
    report = sample.data(tests=1000)
    for test in report["tests"]:
        test["timeline"] = None
    page = watched.open(report, tmp_path, "tests")
    rows, drawn = page.locator("#tests .rows"), page.locator("#tests tbody td.id a")
    names = [test["id"] for test in report["tests"]]
    assert drawn.count() < 200
    page.locator("#tests tbody td.id a").first.focus()
    for share in (0.002, 0.3, 0.31, 0.9, 0.5, 1.0, 0.0):
        rows.evaluate("(box, share) => { box.scrollTop = share * (box.scrollHeight - box.clientHeight); }", share)
        page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
        seen = page.evaluate(
            """() => {
              const box = document.querySelector("#tests .rows").getBoundingClientRect();
              const top = document.querySelector("#tests thead th").getBoundingClientRect().bottom;
              return [...document.querySelectorAll("#tests tbody td.id a")].filter((link) => {
                const at = link.getBoundingClientRect(); return at.bottom > top && at.top < box.bottom;
              }).map((link) => link.textContent);
            }"""
        )
        first = names.index(seen[0])
        assert seen == names[first : first + len(seen)]
        assert len(seen) > 15
        assert abs(first - share * (1000 - len(seen))) < 4
        texts = drawn.all_inner_texts()
        start = names.index(texts[0])
        assert texts == names[start : start + len(texts)]
    watched.assert_quiet()


@pytest.mark.slow
def test_figures_at_lines_plans_and_verdicts_lead_to_their_tests(watched: Watched, tmp_path: Path) -> None:
    report = sample.data(tests=30)
    page = watched.open(report, tmp_path, "code")
    page.locator("#code summary").nth(1).click()
    link = page.locator("#code details[open] .source a").nth(40)
    bit, count = int((link.get_attribute("href") or "").rpartition("/")[2]), int(link.inner_text())
    link.click()
    reach = [test["id"] for test in report["tests"] if int(test["code"]["bits"][0], 16) >> bit & 1]
    listed(page).to_have_text(reach)
    assert len(reach) == count
    assert "that reach controller/states.py:" in page.locator("#tests .notice").inner_text()

    watched.show("plans")
    page.locator("#plans summary").first.click()
    page.locator("#plans details[open] .source a").first.click()
    listed(page).to_have_text([test["id"] for test in report["tests"]])
    watched.show("requirement/R1")
    page.locator("[id='requirement/R1'] a.badge", has_text="NC").click()
    unchecked = [test["id"] for test in report["tests"] if test["requirements"]["R1"]["verdict"] == "NC"]
    listed(page).to_have_text(unchecked)
    page.get_by_role("link", name="show all").click()
    listed(page).to_have_count(30)
    watched.assert_quiet()
