"""The page in a browser: the table of tests, what leads to them, and the page of each."""

from __future__ import annotations

import base64
import shutil
from pathlib import Path
from typing import Any

import pytest

from tests.report import sample, sample_sections, sample_tests
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


def test_interactions_have_a_column_of_their_own_where_the_testbench_does_not_name_them(
    watched: Watched, tmp_path: Path
) -> None:
    report = sample.data(tests=3)
    del report["outcome_label"]
    page = watched.open(report, tmp_path, "tests")
    titles = [title.strip() for title in page.locator("#tests th").all_inner_texts()]
    assert {"Outcome", "Interactions"} <= set(titles)
    assert (
        page.get_by_role("searchbox").get_attribute("placeholder")
        == "Search ids, actions, beliefs, requirements, causes, interactions"
    )


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
def test_rows_have_one_line_and_say_what_each_mark_is(watched: Watched, tmp_path: Path) -> None:
    report = sample.data(("by-hand", "rl"), 40)
    for number in range(60):
        report["requirements"][f"S{number}"] = {"title": f"Rule {number}", "source": "", "text": ""}
        for test in report["tests"]:
            test["requirements"][f"S{number}"] = sample_tests.requirement_result("Passed", 1.0)
    page = watched.open(report, tmp_path, "tests")
    rows = page.locator("#tests tbody tr:not([aria-hidden])")
    heights = rows.evaluate_all("rows => rows.map((row) => row.offsetHeight)")
    assert set(heights) <= {32, 33}
    assert page.locator("#tests .rows").evaluate("box => box.clientWidth") > 1200
    failing = next(n for n, test in enumerate(report["tests"]) if test["requirements"]["R3"]["verdict"] == "Failed")
    rows.nth(failing).locator("i[data-of='2']").hover()
    assert page.locator(".tip").inner_text().startswith("R3 Failed, as is known\nThe robot shall not close")
    page.keyboard.press("Escape")
    assert not page.locator(".tip").is_visible()
    label = rows.nth(failing).locator(".strip").get_attribute("aria-label")
    assert "failed R3;" in (label or "")
    watched.assert_quiet()


@pytest.mark.slow
def test_tests_are_found_by_what_people_do_by_requirements_and_by_causes(watched: Watched, tmp_path: Path) -> None:
    report = sample.data(tests=30)
    report["tests"][3]["id"], report["tests"][4]["id"] = "rl-one", "rl-two"
    report["tests"][7]["abstract"].append("hum a song")
    report["causes"] = sample_sections.CAUSES
    page = watched.open(report, tmp_path, "tests")
    search = page.get_by_label("Search tests")
    search.fill("hum song")
    listed(page).to_have_text([report["tests"][7]["id"]])
    search.fill("close its hand")
    listed(page).to_have_text(
        [test["id"] for test in report["tests"] if test["requirements"]["R3"]["verdict"] == "Failed"]
    )
    search.fill("3f2a91bc")
    listed(page).to_have_text(["rl-one", "rl-two"])
    search.fill("")
    page.locator("#tests").get_by_label("Cause").select_option(index=2)
    listed(page).to_have_text(["rl-one"])
    page.get_by_label("Order").select_option("R3")
    assert page.evaluate("location.hash") == "#tests?cause=2&order=R3"
    watched.assert_quiet()


@pytest.mark.slow
def test_tables_that_come_with_the_page_can_be_sorted(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(sample.data(tests=60), tmp_path)
    watched.show("requirements")
    table = page.locator("#requirements table.sortable").first
    column = [int(text) for text in table.locator("tbody td:nth-child(3)").all_inner_texts()]
    table.get_by_role("button", name="Passed").click()
    assert [int(text) for text in table.locator("tbody td:nth-child(3)").all_inner_texts()] == sorted(column)
    table.get_by_role("button", name="Passed").click()
    assert [int(text) for text in table.locator("tbody td:nth-child(3)").all_inner_texts()] == sorted(column)[::-1]


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
    assert any("details/0001.js" in url for url in watched.requests) == beside
    watched.assert_quiet()


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


@pytest.mark.slow
def test_a_cell_that_counts_others_through_leads_to_the_tests_of_all_of_them(watched: Watched, tmp_path: Path) -> None:
    report = _of_three_coordinates()
    page = watched.open(report, tmp_path, "cross")
    page.get_by_label("Across").select_option("place")
    page.get_by_label("Down").select_option("leg")
    page.wait_for_selector("#cross svg [aria-label=cell] a")
    page.locator("#cross svg [aria-label=cell] a").first.click()
    hit = [test["id"] for test in report["tests"] if test["cross"]["handover"][0][1:] == ["a", "near"]]
    listed(page).to_have_text(hit)
    assert len(hit) == 2
    assert "that hit place near, leg a of handover" in page.locator("#tests .notice").inner_text()
    watched.assert_quiet()


@pytest.mark.slow
def test_actions_have_their_times(watched: Watched, tmp_path: Path) -> None:
    report = sample.data(tests=1)
    report["tests"][0]["acted_s"] = [0.0, 6.25]
    page = watched.open(report, tmp_path, "tests")
    page.locator("#tests td a").first.click()
    page.wait_for_selector("#test .timeline svg")
    times = page.locator("#test .actions tbody td:nth-child(2)").all_inner_texts()
    assert times[:3] == ["0.00 s", "6.25 s", "not done"]
    assert "the human" in (page.locator("#test .timeline svg").first.text_content() or "")


@pytest.mark.slow
def test_each_actor_has_a_row_in_the_timeline(watched: Watched, tmp_path: Path) -> None:
    report = sample.data(tests=1)
    test = report["tests"][0]
    lines = ["nurse: call", "child: run", "disturb slip", "nurse: go"]
    test["abstract"], test["concrete"]["actions"] = lines, [{"command": line, "parameters": {}} for line in lines]
    test["acted_s"], test["acted"], test["seen"] = [0.0, 1.5, 6.25], [2, 1, 3], [[2.5, "dog: bark"]]
    page = watched.open(report, tmp_path, "tests")
    page.locator("#tests td a").first.click()
    page.wait_for_selector("#test .timeline svg")
    times = page.locator("#test .actions tbody td:nth-child(2)").all_inner_texts()
    assert times[:4] == ["1.50 s", "0.00 s", "6.25 s", "not done"]
    drawn = page.locator("#test .timeline svg").first.text_content() or ""
    assert all(name in drawn for name in ("nurse", "child", "dog", "the test"))
    assert "the human" not in drawn
    assert page.get_by_text("What nurse and child do").count() == 1
    watched.assert_quiet()


@pytest.mark.slow
def test_the_smallest_suite_and_what_adds_nothing_are_listed(watched: Watched, tmp_path: Path) -> None:
    report = sample.data(tests=10)
    page = watched.open(report, tmp_path, "closure")
    page.wait_for_selector("#closure figure svg")
    page.get_by_role("link", name="These tests").click()
    listed(page).to_have_text([test["id"] for test in report["tests"][:5]])
    page.get_by_role("button", name="Adds").click()
    adds = page.locator("#tests tbody td:nth-child(6)")
    assert adds.all_inner_texts() == ["4", "5", "6", "7", "8"]
    watched.show("closure")
    page.get_by_role("link", name="tests that add nothing").click()
    listed(page).to_have_text([test["id"] for test in report["tests"][5:]])
    watched.assert_quiet()


@pytest.mark.slow
def test_details_beside_the_page_are_scripts_that_its_policy_lets_run(
    watched: Watched, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pytest_hricdv.report.html.EMBEDDED_BYTES", 1000)
    page = watched.open(sample.data(tests=3), tmp_path, "tests")
    page.locator("#tests td a").first.click()
    page.wait_for_selector("#test .timeline svg")
    watched.assert_quiet()
    assert any(url.endswith("details/0000.js") for url in watched.requests)


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
def test_a_violation_is_marked_where_it_happened(watched: Watched, tmp_path: Path) -> None:
    report = sample.data(tests=60)
    failed = next(test for test in report["tests"] if test["requirements"]["R3"]["verdict"] == "Failed")
    page = watched.open(report, tmp_path, "requirement/R3")
    page.locator("[id='requirement/R3'] table a", has_text=failed["id"]).first.click()
    page.wait_for_selector("#test .timeline svg")
    assert "violated at 51.5 s: hand_distance = 0.03" in page.locator("#test").inner_text()
    marks = page.locator("#test .timeline svg").first.locator("[aria-label=rule][stroke='var(--bad-mark)'] line")
    assert marks.count() == sum(len(result["violations"]) for result in failed["requirements"].values())


@pytest.mark.slow
def test_a_signal_has_gaps_where_the_world_does_not_measure_it(watched: Watched, tmp_path: Path) -> None:
    report = sample.data(tests=2)
    for test in report["tests"]:
        test["timeline"]["signals"] |= {"gap": "0 0.8 7.5 0.2 20 0.3", "leg_held": "0 0 7.5 1 30 0 40 1 45 0"}
    report["sampled_while"] = {"gap": "leg_held"}
    page = watched.open(report, tmp_path, "tests")
    page.locator("#tests td a").first.click()
    page.wait_for_selector("#test .timeline svg[aria-label=gap]")
    plot = page.locator("#test .timeline svg[aria-label=gap]")
    lines = [path.get_attribute("d") for path in plot.locator("[aria-label=line] path").all()]
    assert "".join(lines).count("M") == 2
    ticks = plot.locator("[aria-label='y-axis tick label'] text").all_text_contents()
    assert max(map(float, ticks)) < 0.5  # the value before anything was measured does not stretch the axis
    watched.assert_quiet()


@pytest.mark.slow
def test_states_have_names_in_narrow_spans_too(watched: Watched, tmp_path: Path) -> None:
    report = sample.data(tests=2)
    for test in report["tests"]:
        test["timeline"]["texts"] = {"place": [[0, "elsewhere"], [10, "handover_place"], [14, "resupply"], [15, "bin"]]}
    page = watched.open(report, tmp_path, "tests")
    page.locator("#tests td a").first.click()
    page.wait_for_selector("#test .timeline svg")
    written = page.locator("#test .timeline svg").first.locator("text").all_text_contents()
    assert {"elsewhere", "bin"} <= set(written)
    assert any(text.startswith("han") and text.endswith("…") for text in written)
    named = page.locator("#test .run .legend", has_text="place:").locator("li").all_text_contents()
    assert named == ["place:", "elsewhere", "handover_place", "resupply", "bin"]
    watched.assert_quiet()


@pytest.mark.slow
@pytest.mark.parametrize("number", [0, 3])
def test_a_mark_of_the_margins_leads_to_its_test(watched: Watched, tmp_path: Path, number: int) -> None:
    page = watched.open(sample.data(tests=4), tmp_path, "requirement/R3")
    mark = page.locator("[id='requirement/R3'] [data-plot=margins] svg [aria-label=dot] a").nth(number)
    address = mark.get_attribute("href") or mark.get_attribute("xlink:href")
    mark.click()
    page.wait_for_selector("#test .timeline svg")
    assert page.evaluate("location.hash") == address
    watched.assert_quiet()


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


@pytest.mark.slow
def test_a_run_with_very_many_events_is_drawn_with_as_many_marks_as_can_be_told_apart(
    watched: Watched, tmp_path: Path
) -> None:
    report = sample.data(tests=1)
    [test] = report["tests"]
    times = [round(number * 60 / 30_000, 3) for number in range(30_000)]
    test["timeline"]["messages"] += [f"{time_s}\tcamera\tpicture\t{{}}" for time_s in times]
    outcomes = ["!" if number == 12_345 else "" for number in range(30_000)]
    test["timeline"]["triggers"] = {
        "R1": " ".join(f"{time_s}-{time_s}{mark}" for time_s, mark in zip(times, outcomes, strict=True))
    }
    result = test["requirements"]["R1"]
    result |= {"verdict": "Failed", "triggers": 30_000, "passes": 20_000, "failures": 10_000, "vacuous": 0}
    result["violations"] = [
        {"trigger_s": time_s, "time_s": time_s, "values": {}, "margin": -0.1} for time_s in times[:10_000]
    ]
    page = watched.open(report, tmp_path, "tests")
    page.locator("#tests td a").first.click()
    page.wait_for_selector("#test .timeline svg")
    page.get_by_role("button", name="Whole run").click()
    plot = page.locator("#test .timeline svg").first
    # Four lanes with many marks, each at most 2,000: messages, triggers as bars and as dots, violations with two each.
    assert 5_000 < plot.locator("path, rect, line, circle").count() < 5 * 2_000 + 200
    assert plot.locator("[aria-label=dot] path[fill='var(--bad-mark)']").count() == 1  # the one that failed is kept
    text = page.locator("#test").text_content() or ""
    assert "and 9980 more" in text
    assert text.count("violated at") == 20
    assert "Of more than 2000 marks of a kind as many are drawn." in text
    watched.assert_quiet()
