"""The page as text: well formed, escaped, self-contained, small, and sensible with nothing to show."""

import json
import re
from typing import Any
from urllib.parse import quote

from msgspec.structs import replace

from pytest_hricdv.report import html
from pytest_hricdv.results.model import Report
from tests.report import sample, sample_sections, sample_tests
from tests.report.parsed import Page, details

EVIL = "<script>alert(1)</script>\"'&\x1b[31m\u202e{{ 7 * 7 }}é漢"


def render(report: dict[str, Any] | Report) -> str:
    """The page; its tests' details are in it."""
    text, beside = html.page(report if isinstance(report, Report) else sample.typed(report))
    assert not beside
    return text


def _page(report: dict[str, Any]) -> Page:
    page = Page(render(report))
    page.words = " ".join(page.words.split())
    return page


def test_page_shows_verdicts_closure_sources_and_every_test() -> None:
    report = sample.data(("by-hand", "rl"), 20)
    page = _page(report)
    data = json.loads(page.scripts["data"])
    assert [row[1] for row in data["rows"]] == [test["id"] for test in report["tests"]]
    for text in ("table-assembly", "40 of 40", "Suite by-hand", "no crush prevention", "plan47", "state(278)"):
        assert text in page.words
    assert "controller/journal.py:60" in page.words
    assert "the port never closes in simulation" in page.words
    assert "converged after 130 of 130 iterations" in page.words
    assert set(data["curves"][1]["closure"]) == {"statements", "branches", "plans"}
    assert len(data["curves"][1]["learning"]) == 130
    assert data["marginUnits"] == ["s", "", "", ""]
    assert data["triggers"][3]["suites"].keys() == {"by-hand", "rl"}


def test_the_navigation_has_at_most_seven_entries_for_any_number_of_requirements_and_parts() -> None:
    report = sample.data(("by-hand", "rl"), tests=2)
    for number in range(500):
        name = f"S{number}"
        report["requirements"][name] = {"title": f"Rule {number}", "source": "", "text": "", "group": f"g{number % 3}"}
        for test in report["tests"]:
            test["requirements"][name] = sample_tests.requirement_result("NC", 0)
        for suite in report["suites"]:
            suite["requirements"][name] = suite["requirements"]["R1"]
    report |= {"mutation": sample_sections.MUTATION, "plan": sample_sections.PLAN, "causes": sample_sections.CAUSES}
    report["tests"][0]["id"], report["tests"][1]["id"] = "rl-one", "rl-two"
    page = render(report)
    entries = page.partition("<nav")[2].partition("</nav>")[0]
    assert re.findall(r">([A-Z][^<]+)</a>", entries) == [
        *("Summary", "Causes", "Tests", "Requirements", "Coverage", "Mutants", "Sheet")
    ]
    overview = page.partition('<section class="view" id="requirements">')[2].partition("</section>")[0]
    assert overview.count('<a href="#requirement/') == 504
    assert [overview.count(f">g{group} <span") for group in range(3)] == [1, 1, 1]
    views = set(re.findall('<section class="view" id="([a-z]+)"', page))
    listed = set(re.findall('<a href="#([a-z]+)">', page.partition("</header>")[0]))
    assert views - listed == {"test"}


def test_gaps_come_with_what_may_close_them_and_the_smallest_suite_is_named() -> None:
    report = sample.data(tests=10)
    page = _page(report)
    data = json.loads(page.scripts["data"])
    assert "2 plans plans of human the beliefs leg1 m000l1 reach it" in page.words
    assert "plan47" in page.words
    assert "waived as unreachable: so" not in page.words
    assert "5 tests of 10 cover all that the tests cover together" in page.words
    assert data["minimal"]["gains"] == {str(n): 8 - n for n in range(5)}
    assert data["minimal"]["curve"] == [[0, 0], *([100 * n, 10 * n] for n in range(1, 6))]
    assert "triggered by leg4" in page.words  # the smallest belief set of each plan


def test_a_failed_baseline_is_a_table_of_differences() -> None:
    report = sample.data(tests=2)
    worse = {"suite": "rl", "what": "R3 violated", "before": "1 test", "now": "3 tests", "items": ["rl-1", "rl-2"]}
    better = {"suite": "rl", "what": "statements", "before": "80.00 %", "now": "90.00 %", "items": []}
    texts = ["suite rl: R3 is newly violated by rl-1, rl-2", "suite rl: statements 90.00 %; 80.00 % in the baseline"]
    differences = [{**worse, "worse": True, "text": texts[0]}, {**better, "worse": False, "text": texts[1]}]
    report["gates"] = {"failed": [texts[0], "no NC allowed"], "improved": [texts[1]], "differences": differences}
    words = _page(report).words
    assert "Failed: 1 difference from the baseline for the worse" in words
    assert "R3 violated rl 1 test 3 tests worse rl-1, rl-2" in " ".join(words.split())
    assert "statements rl 80.00 % 90.00 % better" in " ".join(words.split())
    assert "Failed: no NC allowed" in words
    before_sheet = render(report).partition('<section class="view" id="sheet">')[0]
    assert texts[0] not in before_sheet  # it is in the table
    report["gates"]["differences"] = []
    assert f"Failed: {texts[0]}" in _page(report).words


def test_a_test_has_its_details_in_full() -> None:
    report = sample.data(("by-hand", "rl"), 40)
    page = _page(report)
    all_details = [test for number in range(4) for test in details(page, number)]
    assert [test["nodeid"] for test in all_details] == [test["nodeid"] for test in report["tests"]]
    first, shown = report["tests"][0], all_details[0]
    assert f'pytest "{first["nodeid"]}" --hri-suite=by-hand --hri-seed=0' in shown["rerun"]
    assert shown["run"].startswith("sensing_timeout_s ")
    assert shown["timeline"] == first["timeline"]
    assert [verdict["name"] for verdict in shown["verdicts"]] == ["R1", "R2", "R3", "R4"]


def test_sources_say_how_many_tests_reach_each_line() -> None:
    report = sample.data(tests=7)
    line = sample_tests.MAP["controller/journal.py"]["statements"].index(58)
    for test in report["tests"]:
        test["code"]["bits"] = ["0x0", "0x0"]
    report["tests"][2]["code"]["bits"] = report["tests"][5]["code"]["bits"] = [hex(1 << line), "0x1"]
    page = _page(report)
    assert f'<a href="#tests/statement/{line}">2</a>' in render(report)
    assert "58 2 line(58) branch never taken: to line 69" in page.words


def test_nothing_is_fetched_from_anywhere() -> None:
    text = render(sample.data(tests=2))
    for _, attributes in Page(text).tags:
        for name in ("src", "href", "action", "data", "srcset"):
            assert (attributes.get(name) or "#").startswith(("#", "data:"))
    styles = text[: text.index("</style>")]
    assert not re.search(r"https?://|@import|url\(", styles)
    assert "default-src 'none'" in text


def test_links_lead_somewhere() -> None:
    report = sample.data(("by-hand", "rl"), 60)
    page = Page(render(report))
    data = json.loads(page.scripts["data"])
    ids = [attributes["id"] for _, attributes in page.tags if "id" in attributes]
    assert len(ids) == len(set(ids))
    files = {quote(attributes.get("data-title") or "", safe="") for _, attributes in page.tags}
    targets = {*ids, *(f"test/{row[0]}" for row in data["rows"])}
    links = [(attributes["href"] or "")[1:] for tag, attributes in page.tags if tag == "a"]
    assert len(links) > 100
    for link in links:
        link, _, query = link.partition("?")
        assert not query or re.fullmatch(r"(state|outcome|cause)=[a-z%C20-9-]+", query)
        kind, _, chosen = link.partition("/")
        if kind == "tests" and "/" in chosen:
            kind, *numbers = chosen.split("/")
            lists = {"statement": data["statements"], "plan": data["plans"], "verdict": data["requirements"]}
            assert int(numbers[-1]) < len(lists[kind])
        elif kind in ("code", "plans") and chosen:
            assert chosen.partition("@")[0] in files
        else:
            assert link in {*targets, "tests/needed", "tests/needless"}


def _poisoned(value: Any, key: str = "") -> Any:
    """Every text of the report made evil, but those of which the contract lists the values."""
    fixed = (
        "schema",
        "outcome",
        "verdict",
        "bits",
        "by",
        "timeline",
        "cross_products",
        "cross",
        "status",
        "kind",
        "suite",
        "id",
    )
    if key in (*fixed, "suite"):
        return value
    if isinstance(value, dict):
        return {name: _poisoned(inner, name) for name, inner in value.items()}
    if isinstance(value, list):
        return [_poisoned(inner, key) for inner in value]
    return EVIL + value if isinstance(value, str) else value


def poisoned() -> Report:
    """A report in which every name is evil; two have a lone surrogate besides, which has no UTF-8.

    Names of suites and ids of tests are not: a report with such a one is refused.
    """
    report = _poisoned(sample.data(tests=3))
    report["suites"][0]["name"] = "rl"
    plans = {"covered": [EVIL], "missing": [EVIL], "total": 2, "declared": [EVIL], "reached": {}}
    report["suites"][0]["plans"] = {EVIL: plans}
    report["models"] = {EVIL: {"file": EVIL, "source": f"@a +!b. // {EVIL}", "plans": {EVIL: 1}}}
    report["tests"][0]["plans"] = {EVIL: [EVIL]}
    report["tests"][0]["concrete"] = {"actions": [{"command": EVIL, "parameters": {EVIL: 1}}], "run": {EVIL: 2}}
    report["requirements"] |= {EVIL: {"title": EVIL, "source": EVIL, "text": EVIL}}
    report["tests"][0]["requirements"][EVIL] = sample_tests.requirement_result("Failed", 0.1)
    report["tests"][1]["timeline"] = {
        "end_s": 3.0,
        "messages": [f"1\t{EVIL}\t{EVIL}\tno JSON {EVIL}"],
        "signals": {EVIL: "0 1 2 0.5"},
        "triggers": {EVIL: "1-2!"},
    }
    typed = sample.typed(report)
    first = replace(typed.tests[0], id=f"{EVIL}\ud800", failure="\udfff")
    return replace(typed, testbench=f"{EVIL}\ud800", tests=(first, *typed.tests[1:]))


def test_every_text_is_escaped() -> None:
    text = render(poisoned())
    page = Page(text)
    assert page.count("script") == 6  # one line at the top, data, one pack, two libraries, the page's own
    assert "\x1b" not in text
    assert "\u202e" not in text
    assert "{{ 7 * 7 }}" in page.words
    text.encode("utf-8")


def test_page_depends_on_the_content_only() -> None:
    report = sample.data(tests=3)
    assert render(report) == render(json.loads(json.dumps(report, sort_keys=True)))
