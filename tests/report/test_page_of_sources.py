"""Source texts on the page in a browser: figures of files, links to them, and keys from miss to miss."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.report.sources_view import CoverageCount, code_sources
from tests.report import sample
from tests.report.watched import Watched


def _missed() -> dict[str, Any]:
    """A report whose tests reach only every other statement of the journal."""
    report = sample.data(tests=3)
    for test in report["tests"]:
        test["code"]["bits"] = ["0x5555555555", "0x5"]
    return report


def test_what_is_waived_counts_neither_as_covered_nor_as_missing() -> None:
    report = sample.typed(_missed())
    source = next(source for source in code_sources(report) if source.title == "controller/journal.py")
    kinds = [line.kind for line in source.lines]
    file = next(file for file in report.code_under_test.map if file.file == "controller/journal.py")
    assert kinds.count("waived") == source.waived == 1
    assert source.units.total == len(file.statements) - 1
    assert source.units.misses == kinds.count("missed") > 0
    assert source.branches.total == len([arc for arc in file.branches if 60 not in arc])
    assert CoverageCount(1, 3) + CoverageCount(2, 2) == CoverageCount(3, 5)


def test_the_list_of_files_has_totals_and_is_sorted_by_a_click(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(_missed(), tmp_path, "code")
    sources = code_sources(sample.typed(_missed()))
    total = sum((source.units for source in sources), CoverageCount())
    cells = page.locator("#code tfoot td").all_inner_texts()
    assert cells[:3] == ["all", str(total.total), str(total.misses)]
    heading = page.locator("#code .coverage thead th").nth(2).locator("button")
    missing = page.locator("#code .coverage tbody td:nth-child(3)")
    least = sorted(source.units.misses for source in sources)
    heading.click()
    assert [int(text) for text in missing.all_inner_texts()] == least
    heading.click()
    assert [int(text) for text in missing.all_inner_texts()] == least[::-1]
    watched.assert_quiet()


@pytest.mark.slow
def test_a_link_opens_a_file(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(_missed(), tmp_path, "code")
    page.locator("#code .coverage a", has_text="controller/journal.py").click()
    opened = page.locator("#code details[open]")
    assert opened.count() == 1
    assert opened.get_attribute("data-title") == "controller/journal.py"
    page.reload()
    assert opened.get_attribute("data-title") == "controller/journal.py"
    watched.assert_quiet()


@pytest.mark.slow
def test_keys_lead_from_miss_to_miss_and_around(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(_missed(), tmp_path, "code")
    current = page.locator("#code .source .current")

    def line() -> int:
        assert current.count() == 1
        assert current.is_visible()
        assert current.get_attribute("class").split()[0] in ("missed", "partial")
        return int(current.locator("td").first.inner_text())

    page.keyboard.press("n")
    first = line()
    page.keyboard.press("n")
    second = line()
    assert second > first
    page.keyboard.press("p")
    assert line() == first
    page.keyboard.press("p")
    assert "of" in page.locator("#code .misses span").inner_text()
    line()
    page.get_by_role("button", name="Next miss").locator("visible=true").click()
    assert line() == first
    watched.show("tests")
    page.locator("#tests input").first.press("n")
    watched.show("code")
    assert line() == first  # a letter that is typed elsewhere is a letter
    watched.assert_quiet()
