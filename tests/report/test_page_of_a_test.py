"""The page in a browser: the page of one test, its lanes, its film."""

from __future__ import annotations

import base64
import shutil
from pathlib import Path

import pytest

from tests.report import sample
from tests.report.watched import Watched


@pytest.mark.slow
@pytest.mark.parametrize("beside", [False, True])
def test_a_test_has_a_page_of_its_own(
    watched: Watched, tmp_path: Path, beside: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if beside:
        monkeypatch.setattr("pytest_hricdv.report.html.EMBEDDED_BYTES", 1000)
    report = sample.data(tests=60)
    page = watched.open(report, tmp_path, "tests")
    last = report["tests"][-1]
    page.get_by_role("link", name=last["id"]).click()
    page.wait_for_selector("#test .timeline svg")
    words = page.locator("#test").inner_text()
    for text in (last["nodeid"], *last["beliefs"], *last["abstract"], "--hri-suite=rl --hri-seed=0"):
        assert text in words
    lanes = page.locator("#test .timeline svg").first.text_content()
    for lane in ("state", "request", "reading", "leg_held", "R4"):
        assert lane in lanes
    assert "simulated time (s)" in page.get_by_role("slider").text_content()
    assert "arm_speed (rad/s)" in (page.locator("#test .timeline").text_content() or "")
    page.get_by_role("link", name="← previous").click()
    page.wait_for_function(
        "id => document.querySelector('#test h2').textContent.includes(id)", arg=report["tests"][-2]["id"]
    )
    page.go_back()
    page.wait_for_function("id => document.querySelector('#test h2').textContent.includes(id)", arg=last["id"])
    assert any("details/0002.js" in url for url in watched.requests) == beside
    watched.assert_quiet()


@pytest.mark.slow
def test_details_that_are_not_beside_the_page_are_missed_by_name(
    watched: Watched, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pytest_hricdv.report.html.EMBEDDED_BYTES", 1000)
    report = sample.data(tests=3)
    page = watched.open(report, tmp_path, "tests")
    shutil.rmtree(tmp_path / "details")
    page.locator("#tests td a").first.click()
    page.wait_for_selector("#test .notice")
    assert "details/0000.js is missing beside this page" in page.locator("#test").inner_text()
    watched.show("test/nosuchtest")
    assert "There is no such test in this report." in page.locator("#test").inner_text()


@pytest.mark.slow
@pytest.mark.parametrize(("video", "tag"), [("a.mp4", "video"), ("a.gif", "img")])
def test_a_film_is_shown_with_its_strip(watched: Watched, tmp_path: Path, video: str, tag: str) -> None:
    report = sample.data(tests=2)
    report["tests"][0]["film"] = {
        "video": f"films/{video}",
        "strip": "films/a.png",
        "seconds": 2.0,
        "frames": 24,
        "note": "the run differs from the recording",
    }
    (tmp_path / "films").mkdir()
    picture = base64.b64decode("R0lGODlhAQABAIAAAAAAAP///yH5BAEAAAAALAAAAAABAAEAAAIBRAA7")
    for name in ("a.png", "a.gif", "a.mp4"):
        (tmp_path / "films" / name).write_bytes(picture)
    page = watched.open(report, tmp_path, "tests")
    page.locator("#tests td a").first.click()
    assert page.locator("#test a img").get_attribute("src") == "films/a.png"
    assert page.locator(f"#test {tag}.film").last.get_attribute("src") == f"films/{video}"
    assert "the run differs from the recording" in page.locator("#test").inner_text()
    watched.assert_quiet()
