"""Changes of behaviour in the views: the terminal, the page, the summary of a CI job."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from pytest_hricdv.report.behaviour_view import lines, sentence
from pytest_hricdv.report.formatting import width
from pytest_hricdv.report.junit import junit_suite_properties
from pytest_hricdv.report.markdown import markdown
from pytest_hricdv.report.tests_view import anchor
from pytest_hricdv.results.baseline import baseline_of
from pytest_hricdv.results.behaviour_diff import compare_behaviour
from pytest_hricdv.results.model import Report
from tests.report import sample
from tests.report.parsed import Page, details
from tests.report.test_html import render
from tests.report.watched import Watched, listed

LATER = "`request` later"
OTHER = "`state(Give up)` instead of `state(Offer)`"


def compared(before: dict[str, Any], now: dict[str, Any], *, whole: bool = True) -> Report:
    """A report compared with an earlier one."""
    report = sample.typed(now)
    return replace(report, changes=compare_behaviour(report, baseline_of(sample.typed(before)), whole=whole))


def say(test: dict[str, Any], place: int, message: str) -> None:
    """Let the run of a test have another message."""
    test["timeline"]["messages"][place] = message
    test["record_sha256"] = "00" * 32


def changed() -> Report:
    """Of six tests, two ask later, one gives up and ends so, one has another signal, one is new and one is gone."""
    now = sample.data(tests=6)
    before = copy.deepcopy(now)
    for test in now["tests"][:2]:
        say(test, 4, "7\thuman\trequest\t{}")
    say(now["tests"][2], 2, '2\trobot\tstate\t{"name":"Give up"}')
    now["tests"][2]["end_reason"] = "given up"
    now["tests"][3]["record_sha256"] = "11" * 32
    now["tests"][3]["timeline"]["checksums"] = {"arm_speed": "0a"}
    before["tests"][4]["id"] = before["tests"][4]["nodeid"] = "rl-old"
    return compared(before, now)


def test_the_terminal_lists_kinds_with_an_example_each_within_its_width() -> None:
    report = changed()
    first, second, third, fourth, fifth, _ = (test.id for test in report.tests)
    shown = [line.text for line in lines(report, 110)]
    assert shown == [
        "4 of 5 tests behave differently from the baseline",
        f"  2  {LATER}",
        f"     first difference in {min(first, second)}: at 7.0 s `request`, 1.5 s later than before",
        f"  1  {OTHER}",
        f"     first difference in {third}: at 2.0 s `state(Give up)` instead of `state(Offer)`",
        "  1  only signals differ",
        f"     first difference in {fourth}: the messages are the same, but signal arm_speed is new",
        f"  1 test not in the baseline: {fifth}",
        "  1 test only in the baseline: rl-old",
        "  the code under test is the same as before, so the testbench, its world, the model or a library has changed,",
        "  or runs depend on something that changes each time, such as a clock",
    ]
    assert all(width(line.text) <= 60 for line in lines(report, 60))
    assert list(lines(sample.report(), 100)) == []


def test_a_ci_job_gets_one_line_and_a_property() -> None:
    report = changed()
    (line,) = [line for line in markdown(report).splitlines() if line.startswith("Behaviour: ")]
    assert line.startswith("Behaviour: 4 of 5 tests behave differently from the baseline; first difference in rl-leg")
    assert line.endswith("at 7.0 s \\`request\\`, 1.5 s later than before")
    assert ("hri.behave_otherwise", "4") in junit_suite_properties(report)
    without = sample.report()
    assert sentence(without) == ""
    assert "Behaviour:" not in markdown(without)
    assert "hri.behave_otherwise" not in dict(junit_suite_properties(without))


def test_the_page_lists_kinds_and_has_both_runs_of_each_test_that_changed() -> None:
    report = changed()
    page = Page(render(report))
    words = " ".join(page.words.split())
    assert "Compared with the baseline 4 of 5 tests behave differently from the baseline ." in words
    assert "request later 2" in words
    assert "state(Give up) instead of state(Offer) 1" in words
    assert "1 test only in the baseline: rl-old" in words
    assert json.loads(page.scripts["data"])["changes"][0] == {"kind": LATER, "tests": [0, 1]}
    *_, third, fourth, fifth, _ = (test["changed"] for test in details(page, 0))
    assert third["also"] == ["ended with 'given up' instead of 'table done'"]
    assert third["before"]["messages"][2] == '2\trobot\tstate\t{"name": "Offer"}'
    assert fourth["time"] is None
    assert fifth is None


@pytest.mark.slow
@pytest.mark.parametrize("at_a_desk", [True, False])
def test_the_page_of_a_changed_test_shows_both_timelines(browser: Any, tmp_path: Path, at_a_desk: bool) -> None:
    columns = 1280 if at_a_desk else 390
    watched = Watched(browser, viewport={"width": columns, "height": 900})
    report = changed()
    third = report.tests[2]
    page = watched.open(report, tmp_path, f"test/{anchor(third.nodeid)}")
    card = page.locator("#test section", has_text="Compared with the baseline")
    card.locator("svg").nth(3).wait_for()
    assert card.locator("svg[aria-label^=Messages]").count() == 2
    for plot in card.locator("svg[aria-label^=Messages]").all():
        assert "request" in (plot.text_content() or "")
    assert "First difference: at 2.0 s state(Give up) instead of state(Offer)." in card.inner_text()
    assert "ended with 'given up'" in card.inner_text()
    differing = card.locator("tr.missed td").all_inner_texts()
    assert differing == ["2.000 s robot state name=Offer", "2.000 s robot state name=Give up"]
    boxes = [figure.bounding_box() for figure in card.locator("figure").all()]
    assert (boxes[0]["y"] == boxes[1]["y"]) == at_a_desk
    assert page.evaluate("document.documentElement.scrollWidth") <= columns
    watched.show("tests/changed/0")
    listed(page).to_have_text(sorted(test.id for test in report.tests[:2]))
    assert "that behave differently than before: `request` later" in page.locator("#tests .notice").inner_text()
    watched.show("tests/changed")
    listed(page).to_have_count(4)
    watched.assert_quiet()
    page.context.close()
