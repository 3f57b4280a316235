"""The page in a browser: heat maps of cross products, and the tests that their cells lead to."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.report import sample, sample_tests
from tests.report.watched import Watched, listed


@pytest.mark.slow
def test_a_cell_of_a_heat_map_leads_to_its_tests(watched: Watched, tmp_path: Path) -> None:
    report = sample.data(tests=30)
    page = watched.open(report, tmp_path, "cross")
    page.wait_for_selector("#cross svg [aria-label=cell] a")
    address = page.locator("#cross svg [aria-label=cell] a").first.get_attribute("href")
    *_, across, leg, down, gpl = address.split("/")
    assert (across, down) == ("1", "0")
    page.evaluate("address => { location.hash = address; }", address)
    bins = [sample_tests.GPL[int(gpl)], sample_tests.LEGS[int(leg)]]
    hit = [test["id"] for test in report["tests"] if bins in test["cross"]["handover"]]
    listed(page).to_have_text(hit)
    assert f"that hit leg {bins[1]}, gpl {bins[0]} of handover" in page.locator("#tests .notice").inner_text()
    watched.assert_quiet()


def _of_three_coordinates() -> dict[str, Any]:
    """A cross product of 2 x 3 x 2: the model makes "away" impossible but for one test, and "c" illegal with "far"."""
    report = sample.data(("by-hand", "rl"), 2)
    coordinates = {"mood": ("calm", "away"), "leg": ("a", "b", "c"), "place": ("near", "far")}
    away = [["away", leg, place] for leg in "abc" for place in ("near", "far")]
    report["cross_products"] = {
        "handover": {
            "coordinates": [{"name": name, "bins": list(bins)} for name, bins in coordinates.items()],
            "impossible": [{"bin": bin_, "reason": "the model never does", "by": "model"} for bin_ in away],
            "illegal": [{"bin": ["calm", "c", "far"], "reason": "out of reach"}],
            "proof": {"status": "proven", "reason": "", "runs": 9},
        }
    }
    hits = [["calm", "a", "near"], ["calm", "a", "far"], ["away", "a", "near"], ["calm", "c", "far"]]
    for test, hit in zip(report["tests"], hits, strict=True):
        test["cross"] = {"handover": [hit]}
    for suite, mine in zip(report["suites"], (hits[:2], hits[2:]), strict=True):
        suite["cross"]["products"]["handover"]["hits"] = [{"bin": hit, "tests": 1, "hits": 1} for hit in mine]
    return report


def test_two_of_several_coordinates_are_chosen_and_the_others_counted_through(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(_of_three_coordinates(), tmp_path, "cross")
    cells = page.locator("#cross svg [aria-label=text] text")
    page.wait_for_selector("#cross svg [aria-label=text] text")
    # Down the moods, across the legs: hit of possible; "away" is possible where a test did it all the same.
    assert cells.all_text_contents() == ["2/2", "0/2", "!1", "1/1", "–", "–"]
    page.get_by_label("Down").select_option("leg")
    page.get_by_label("Across").select_option("place")
    assert cells.all_text_contents() == ["2/2", "1/1", "0/1", "0/1", "0/1", "!1"]
    page.locator("#cross").get_by_label("Suite").select_option("by-hand")
    assert cells.all_text_contents() == ["1/1", "1/1", "0/1", "0/1", "0/1", "–"]
    page.get_by_label("Across").select_option("leg")
    assert cells.all_text_contents() == ["2/2", "0/2", "0/1"]
    watched.assert_quiet()
