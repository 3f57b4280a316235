"""The page: well formed, escaped, self-contained, small, and sensible with nothing to show."""

import json
import re
from html.parser import HTMLParser
from typing import Any

import pytest

from pytest_hricdv.report.html import render
from tests.report import sample

VOID = {"meta", "link", "br", "input", "hr", "img"}
EVIL = "<script>alert(1)</script>\"'&\x1b[31m\u202e{{ 7 * 7 }}\ud800é漢"


class Page(HTMLParser):
    """The elements of a page; fails where a tag is not closed in order."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words = ""
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag, f"</{tag}> at {self.getpos()}"

    def handle_data(self, data: str) -> None:
        if not {"script", "style"} & set(self.open):
            self.words += f" {data} "

    def count(self, tag: str, name: str = "") -> int:
        return sum(each == tag and (not name or name in (attrs.get("class") or "")) for each, attrs in self.tags)


def _page(report: dict[str, Any]) -> Page:
    page = Page(render(report))
    page.words = " ".join(page.words.split())
    return page


def _bare(report: dict[str, Any]) -> dict[str, Any]:
    return {key: report[key] for key in ("schema", "selected", "reported", "not_run", "suites", "tests")}


def test_page_shows_verdicts_charts_closure_and_every_test() -> None:
    report = sample.report(("by-hand", "rl"), 20)
    page = _page(report)
    assert page.count("details", "test") == 40
    assert page.count("svg", "chart") == 5
    for text in ("table-assembly", "40 of 40", "Suite by-hand", "no crush prevention", "plan47, plan48", "Charts"):
        assert text in page.words
    assert "controller/journal.py:60" in page.words
    assert "the port never closes in simulation" in page.words
    assert "converged at 130" in page.words
    first = report["tests"][0]
    assert f'pytest "{first["nodeid"]}" --hri-suite=by-hand --hri-seed=0' in page.words
    assert "sensing_timeout_s=" in page.words


def test_nothing_is_fetched_from_anywhere() -> None:
    text = render(sample.report(tests=2))
    for _, attributes in Page(text).tags:
        for name in ("src", "href", "action", "data", "srcset"):
            assert (attributes.get(name) or "#").startswith(("#", "data:"))
    assert not re.search(r"https?://|@import|url\(", text)
    assert "default-src 'none'" in text


def test_links_lead_somewhere() -> None:
    report = sample.report(("by-hand", "rl"), 60)
    page = Page(render(report))
    ids = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert len(ids) == len(set(ids))
    links = [attributes["href"] for tag, attributes in page.tags if tag == "a"]
    assert len(links) > 4
    assert all(link is not None and link[1:] in ids for link in links)


def _poisoned(value: Any, key: str = "") -> Any:
    """Every text of the report made evil, but those of which the contract lists the values."""
    if isinstance(value, dict):
        return {name: _poisoned(inner, name) for name, inner in value.items()}
    if isinstance(value, list):
        return [_poisoned(inner, key) for inner in value]
    fixed = key in ("schema", "outcome", "verdict")
    return EVIL + value if isinstance(value, str) and not fixed else value


def test_every_text_is_escaped() -> None:
    report = _poisoned(sample.report(tests=3))
    report["suites"][0]["plans"] = {EVIL: {"covered": [EVIL], "missing": [EVIL], "total": 2}}
    report["tests"][0]["plans"] = {EVIL: [EVIL]}
    report["tests"][0]["concrete"] = {"actions": [{"command": EVIL, "parameters": {EVIL: EVIL}}, EVIL], EVIL: EVIL}
    text = render(report)
    page = Page(text)
    assert page.count("script") == 1
    assert "\x1b" not in text
    assert "\u202e" not in text
    assert "{{ 7 * 7 }}" in page.words
    text.encode("utf-8")


def test_150_tests_stay_under_two_megabytes() -> None:
    assert len(render(sample.report(tests=150)).encode()) < 2_000_000


def test_long_learning_does_not_bloat_the_page() -> None:
    report = sample.report(tests=1)
    report["suites"][0]["generation"]["q_delta"] = [1.0 / n for n in range(1, 50_001)]
    assert len(render(report)) < 100_000


def test_page_depends_on_the_content_only() -> None:
    report = sample.report(tests=3)
    assert render(report) == render(json.loads(json.dumps(report, sort_keys=True)))


@pytest.mark.parametrize("tests", [0, 1, 3])
def test_bare_report_has_a_page(tests: int) -> None:
    page = _page(_bare(sample.report(tests=tests)))
    assert page.count("details", "test") == tests
    assert ("No test was selected." in page.words) == (tests == 0)


def test_report_without_suites_has_a_page() -> None:
    page = _page({**_bare(sample.report(tests=0)), "suites": []})
    assert "No suite was run." in page.words
    assert page.count("svg", "chart") == 0


def test_unmeasured_code_is_called_so() -> None:
    report = sample.report(tests=2)
    report["code_under_test"] = {"measured": False, "reason": "a debugger owns sys.settrace"}
    report["suites"][0]["code"] = {"statements": None, "branches": None}
    for test in report["tests"]:
        test["code"] = None
    page = _page(report)
    assert "unmeasured a debugger owns sys.settrace" in page.words
    assert "Coverage per test" not in page.words
    assert "Closure: statements" not in page.words
    assert "Closure: plans" in page.words


def test_all_unchecked_and_nothing_learned() -> None:
    report = sample.report(("pseudorandom",), 2)
    for test in report["tests"]:
        test["requirements"] = {name: sample.judged("NC", 0) for name in test["requirements"]}
    report["suites"][0]["requirements"] = {"R1": {"passed": 0, "failed": 0, "nc": 2, "triggers": 0}}
    page = _page(report)
    assert "Learning" not in page.words
    assert "R1 NC" in page.words
    assert "nearest at 41.2 s: only reading.pressure was missing" in page.words


def test_tests_that_never_ran_are_pointed_out() -> None:
    report = sample.report(tests=2)
    lost = {"outcome": "not-run", "wall_s": None, "sim_s": None, "frozen_s": None, "seed": None, "concrete": None}
    report["tests"][0].update(lost, requirements={}, code=None, legs=[], failure="worker gw1 crashed")
    report.update(reported=1, not_run=1)
    page = _page(report)
    assert "Expected 2 tests, reported 1: 1 test not run or lost" in page.words
    assert "Needs a look" in page.words
    assert "worker gw1 crashed" in page.words


def test_q_that_stops_changing_is_drawn_on_the_lower_edge() -> None:
    report = sample.report(tests=1)
    for changes in ([1.0, 0.1, 0.0, 0.0], [0.0, 0.0], [0.5], [1.0, 5e-324], [1e308, 1e-12]):
        report["suites"][0]["generation"]["q_delta"] = changes
        page = _page(report)
        assert "Learning" in page.words
