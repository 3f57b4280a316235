"""The page for people who do not see it, or use a keyboard: what axe finds, and tables for plots."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest

from tests.report import sample, sample_sections
from tests.report.test_page_navigation import with_parts
from tests.report.watched import Watched

RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"]
RUN = """rules => axe.run(document, { runOnly: rules }).then((found) => found.violations.map((each) =>
  each.id + ": " + each.nodes.slice(0, 3).map((node) => node.html.slice(0, 120)).join(" | ")))"""


@pytest.mark.slow
@pytest.mark.parametrize(("width", "scheme"), [(1440, "light"), (390, "dark")])
def test_axe_finds_nothing_in_any_view(browser: Any, tmp_path: Path, width: int, scheme: Any) -> None:
    pytest.importorskip("axe_playwright_python", reason="axe-core is in the dependency group test")
    axe = files("axe_playwright_python").joinpath("axe.min.js").read_text(encoding="utf-8")
    watched = Watched(browser, viewport={"width": width, "height": 900}, color_scheme=scheme)
    page = watched.open(with_parts() | {"closing": sample_sections.CLOSING}, tmp_path)
    page.evaluate(axe)  # the page's policy lets no further script element run
    links = page.evaluate("() => [...document.querySelectorAll('header nav a')].map((link) => link.hash.slice(1))")
    test = page.evaluate("() => JSON.parse(document.getElementById('data').textContent).rows[0][0]")
    assert len(set(links)) >= 11
    for view in [*dict.fromkeys(links), "requirement/R3", f"test/{test}"]:
        watched.show(view)
        if view.startswith("test/"):
            page.wait_for_selector("#test svg")
        assert page.evaluate(RUN, RULES) == [], view
    page.context.close()


@pytest.mark.slow
def test_every_plot_with_figures_has_them_as_a_table(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(with_parts() | {"closing": sample_sections.CLOSING}, tmp_path)
    for view, plots in (("closure", 3), ("suites", 5), ("requirement/R3", 2), ("cross", 1)):
        watched.show(view)
        shown = page.locator(".view:not([hidden])")
        tables = shown.locator("details.tabled")
        assert tables.count() == shown.locator("svg[role]").count() == plots
        tables.first.locator("summary").click()
        assert tables.first.locator("tbody tr").count() > 0
    watched.show("requirement/R3")
    margins = page.locator("[id='requirement/R3'] details.tabled").last
    margins.locator("summary").click()
    margins.locator("a").first.click()
    page.wait_for_selector("#test:not([hidden]) svg")
    watched.assert_quiet()


@pytest.mark.slow
def test_what_is_folded_is_opened_and_tests_are_reached_with_a_keyboard(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(sample.data(tests=12), tmp_path, "closure")
    page.locator("#closure .hole summary").first.focus()
    page.keyboard.press("Enter")
    assert page.locator("#closure .hole[open] tbody tr").count() > 0
    watched.show("tests")
    page.get_by_label("Search tests").focus()
    for _ in range(40):
        page.keyboard.press("Tab")
        if page.evaluate("() => document.activeElement.matches('#tests td.id a')"):
            break
    page.keyboard.press("Enter")
    page.wait_for_selector("#test:not([hidden]) svg")
    watched.assert_quiet()
