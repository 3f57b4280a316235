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


def _named(report: dict[str, Any], names: dict[str, str]) -> dict[str, Any]:
    """The report with other names of requirements."""
    report["requirements"] = {names[name]: texts for name, texts in report["requirements"].items()}
    for part in (*report["tests"], *report["suites"]):
        part["requirements"] = {names[name]: result for name, result in part["requirements"].items()}
    return report


def test_a_report_of_no_test_has_no_smallest_suite_and_no_dangling_figures() -> None:
    words = " ".join(Page(html.page(sample.report(suites=(), tests=0))[0]).words.split())
    assert "0 of 0 Suites none" in words
    assert "smallest suite" not in words
    assert "No suite was run" in words


def test_tests_that_failed_are_named_before_those_that_did_not_run() -> None:
    report = sample.data(tests=4)
    for number, test in enumerate(report["tests"]):
        test["outcome"] = "failed" if number == 3 else "not-run"
    words = " ".join(Page(html.page(sample.typed(report))[0]).words.split())
    listed = words[words.index("Failed or not run") :]
    assert listed.index(report["tests"][3]["id"]) < listed.index(report["tests"][0]["id"])


@pytest.mark.parametrize(("outcome", "heading"), [("failed", "Failed"), ("not-run", "Not run")])
def test_a_list_of_tests_that_are_all_alike_is_called_what_they_are(outcome: str, heading: str) -> None:
    report = sample.data(tests=2)
    for test in report["tests"]:
        test["outcome"] = outcome
    page = html.page(sample.typed(report))[0]
    assert f"<h3>{heading}</h3>" in page
    assert "Failed or not run" not in page


@pytest.mark.parametrize(
    ("outcomes", "said"),
    [
        (("failed", "known-violation"), "All 2 tests , 1 of which fails as is known."),
        (("failed", "failed"), "All 2 tests ."),
    ],
)
def test_a_cause_says_how_many_of_its_tests_do_not_fail_the_run(outcomes: tuple[str, str], said: str) -> None:
    report = with_parts()
    for test, outcome in zip(report["tests"], outcomes, strict=False):
        test["outcome"] = outcome
    assert said in " ".join(Page(html.page(sample.typed(report))[0]).words.split())


@pytest.mark.slow
def test_plots_and_columns_that_would_be_empty_are_not_there(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(sample.report(suites=(), tests=0), tmp_path / "none", "suites")
    assert page.locator("#suites figure").count() == 0
    watched.show("closure")
    assert page.locator("#closure figure").count() == 0
    report = sample.data(tests=1)
    report["suites"][0]["generation"] |= {"iterations": 0, "q_delta": []}
    for test in report["tests"]:
        test["outcomes"] = []
    watched.open(report, tmp_path / "one", "suites")
    assert page.locator("#suites figure:visible").count() > 0
    assert "Learning" not in page.locator("#suites").inner_text()
    assert ".000000" not in page.locator("#suites").inner_text()
    watched.show("tests")
    assert report["outcome_label"].capitalize() not in page.locator("#tests thead").inner_text()
    watched.assert_quiet()


@pytest.mark.slow
@pytest.mark.parametrize("width", [390, 1440])
def test_of_names_that_are_cut_there_is_what_tells_them_apart(browser: Any, tmp_path: Path, width: int) -> None:
    names = {f"R{number}": f"stops-when-near-a-person-{number}" for number in range(1, 5)}
    report = _named(sample.data(tests=6), names)
    for number, test in enumerate(report["tests"]):
        test["id"] = f"rl-{'a-person-who-looks-away-' * 3}{number:08x}"
    watched = Watched(browser, viewport={"width": width, "height": 900})
    page = watched.open(report, tmp_path, "tests")
    heads = page.locator("#tests thead .strip button")
    assert len(set(heads.all_inner_texts())) == heads.count() == 4
    assert all(heads.evaluate_all("all => all.map((head) => head.scrollHeight <= head.clientHeight)"))
    ends = page.evaluate(
        """() => [...document.querySelectorAll("#tests td.id")].map((cell) => {
          const end = cell.querySelector("a").lastChild, range = document.createRange();
          range.selectNode(end);
          const seen = range.getBoundingClientRect(), box = cell.getBoundingClientRect();
          return [end.textContent, seen.width > 0 && seen.right <= box.right && seen.left >= box.left];
        })"""
    )
    assert ends == [[f"-{number:08x}", True] for number in range(6)]
    assert page.locator("#tests td.id a").all_inner_texts() == [test["id"] for test in report["tests"]]
    page.context.close()


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
