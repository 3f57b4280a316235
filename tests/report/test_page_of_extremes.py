"""The page of reports with nothing, with one test, and with names that do not fit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.report import html
from tests.report import sample, sample_sections
from tests.report.parsed import Page
from tests.report.test_page_navigation import with_parts
from tests.report.watched import Watched


def test_a_report_of_no_test_has_no_smallest_suite_and_no_dangling_figures() -> None:
    words = " ".join(Page(html.page(sample.report(suites=(), tests=0))[0]).words.split())
    assert "0 of 0 Suites none" in words
    assert "smallest suite" not in words
    assert "No suite was run" in words


@pytest.mark.parametrize(("outcome", "heading"), [("failed", "Failed"), ("not-run", "Not run")])
def test_a_list_of_tests_that_are_all_alike_is_called_what_they_are(outcome: str, heading: str) -> None:
    report = sample.data(tests=2)
    for test in report["tests"]:
        test["outcome"] = outcome
    page = html.page(sample.typed(report))[0]
    assert f"<h3>{heading}</h3>" in page
    assert "Failed or not run" not in page


@pytest.mark.slow
def test_on_a_phone_every_figure_of_a_table_is_in_sight_and_has_a_name(browser: Any, tmp_path: Path) -> None:
    watched = Watched(browser, viewport={"width": 390, "height": 900})
    page = watched.open(with_parts() | {"suggestions": sample_sections.SUGGESTIONS}, tmp_path)
    for view in ("sheet", "plan", "suggestions"):
        watched.show(view)
        outside = page.evaluate(
            """() => [...document.querySelectorAll(".view:not([hidden]) :is(td, th)")].filter((cell) =>
              cell.getClientRects().length && cell.getBoundingClientRect().right > innerWidth)
              .map((cell) => cell.textContent)"""
        )
        assert outside == [], view
        unnamed = page.evaluate(
            """() => [...document.querySelectorAll(".view:not([hidden]) td.n")].filter((cell) =>
              getComputedStyle(cell, "::before").content === "none").map((cell) => cell.textContent)"""
        )
        assert unnamed == [], view
    page.context.close()
