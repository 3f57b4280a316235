"""The page in a browser: it needs no network, complains of nothing, and does what it offers."""

from __future__ import annotations

import base64
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.report import write
from tests.report import sample
from tests.report.test_html import poisoned, with_closure

sync_api = pytest.importorskip("playwright.sync_api", reason="needs playwright: pip install --group dev")

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
VIEWS = ["summary", "suites", "closure", "requirement/R1", "requirement/R3", "code", "plans", "cross", "tests"]


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Chromium without a head: the machine's own, or the one that playwright has installed."""
    found = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
    with sync_api.sync_playwright() as playwright:
        quiet = ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update"]
        try:
            browser = playwright.chromium.launch(executable_path=found, args=quiet)
        except sync_api.Error as error:
            pytest.skip(
                f"no Chromium: install one (Debian: apt install chromium) or set CHROMIUM ({error.message:.80})"
            )
        yield browser
        browser.close()


class Watched:
    """A page, and everything that it complained of or asked for."""

    def __init__(self, browser: Any, **options: Any) -> None:
        context = browser.new_context(offline=True, reduced_motion="reduce", **options)
        context.set_default_timeout(20_000)
        self.page = context.new_page()
        self.complaints: list[str] = []
        self.asked: list[str] = []
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("console", lambda message: self.complaints.append(message.text))
        self.page.on("dialog", lambda dialog: self.complaints.append(f"dialog: {dialog.message}"))
        self.page.on("request", lambda request: self.asked.append(request.url))

    def open(self, report: dict[str, Any], folder: Path, view: str = "summary") -> Any:
        """Write the report, open its page at a view, and wait until it is ready."""
        write(report, folder)
        self.page.goto(f"file://{folder}/index.html#{view}")
        self.page.wait_for_selector("html[data-ready]", state="attached")
        return self.page

    def show(self, view: str) -> None:
        """Go to another view of the page; its plots are drawn when this returns."""
        self.page.evaluate("view => { location.hash = view; }", view)
        self.page.wait_for_function(
            "view => document.querySelector(`.view:not([hidden])`).id === view.split('/')[0] || "
            "document.querySelector(`.view:not([hidden])`).id === view",
            arg=view,
        )
        self.page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def quiet(self) -> bool:
        """Whether nothing was complained of, and nothing asked for but files beside the page."""
        assert self.complaints == []
        assert all(url.startswith(("file:", "data:", "blob:")) for url in self.asked), self.asked
        return True


@pytest.fixture
def watched(browser: Any) -> Iterator[Watched]:
    """A page as wide as a desk's screen."""
    found = Watched(browser, viewport={"width": 1280, "height": 900})
    yield found
    found.page.context.close()


def listed(page: Any) -> Any:
    """The ids of the tests that the table lists; to be waited for, as a link shows it only when its click is over."""
    return sync_api.expect(page.locator("#tests td:first-child a"))


CONTRAST = """() => {
  const shade = (text) => text.match(/[\\d.]+/g).map(Number);
  const linear = (x) => x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4;
  const light = (rgb) => [0.2126, 0.7152, 0.0722].reduce((sum, weight, n) => sum + weight * linear(rgb[n] / 255), 0);
  const behind = (element) => {
    for (let at = element; at; at = at.parentElement) {
      const found = shade(getComputedStyle(at).backgroundColor);
      if (found.length === 3 || found[3] > 0) return found;
    }
  };
  const poor = [];
  for (const element of document.querySelectorAll("main *, header *")) {
    const own = [...element.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim());
    if (!own || !element.checkVisibility() || element.closest("svg")) continue;
    const [a, b] = [light(shade(getComputedStyle(element).color)), light(behind(element))];
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < 4.5) poor.push(element.outerHTML.slice(0, 80) + " " + ratio.toFixed(2));
  }
  return poor;
}"""


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 375])
def test_every_view_is_legible_on_screens_of_any_kind(browser: Any, tmp_path: Path, scheme: Any, width: int) -> None:
    watched = Watched(browser, viewport={"width": width, "height": 800}, color_scheme=scheme)
    report = with_closure(sample.report(("by-hand", "rl"), 12))
    page = watched.open(report, tmp_path)
    test = page.evaluate("() => JSON.parse(document.getElementById('data').textContent).rows[0][0]")
    for view in [*VIEWS, f"test/{test}"]:
        watched.show(view)
        if view.startswith("test/"):
            page.wait_for_selector("#test .timeline svg")
        assert page.evaluate("document.documentElement.scrollWidth") <= width, f"{view} is wider than the screen"
        assert page.evaluate(CONTRAST) == [], view
        page.screenshot(path=tmp_path / f"{view.replace('/', '-')}.png")
    assert watched.quiet()
    page.context.close()


def test_plots_have_axes_with_units_and_legends(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(sample.report(("by-hand", "rl"), 12), tmp_path, "suites")
    assert page.locator("#suites figure svg[aria-label]").count() == 5
    words = page.locator("#suites").text_content()
    for text in ("tests run →", "statements covered (%)", "iteration →", "largest change of Q"):
        assert text in words
    assert page.locator("#suites figure .legend li").count() == 9  # learning is of one suite only
    watched.show("requirement/R1")
    words = page.locator("[id='requirement/R1']").text_content()
    assert "simulated time (s) →" in words
    assert "margin (s) →" in words
    assert watched.quiet()


def test_the_table_of_tests_is_sorted_and_searched(watched: Watched, tmp_path: Path) -> None:
    report = sample.report(("by-hand", "rl"), 80)
    page = watched.open(report, tmp_path, "tests")
    listed(page).to_have_count(100)
    page.get_by_role("button", name="More").click()
    listed(page).to_have_count(60)

    page.get_by_role("button", name="Simulated").click()
    ascending = [test["id"] for test in sorted(report["tests"], key=lambda test: test["sim_s"])]
    listed(page).to_have_text(ascending[:100])
    page.get_by_role("button", name="Simulated").click()
    listed(page).to_have_text(ascending[:-101:-1])
    assert page.locator("#tests th[aria-sort=descending]").inner_text().strip() == "Simulated"

    page.get_by_role("searchbox").fill("RL leg4")
    found = [each for each in ascending[::-1] if each.startswith("rl-leg4")]
    listed(page).to_have_text(found)
    page.get_by_label("Outcome").select_option("failed")
    failed = {test["id"] for test in report["tests"] if test["outcome"] == "failed"}
    listed(page).to_have_text([each for each in found if each in failed])
    page.get_by_role("searchbox").fill("no such test")
    listed(page).to_have_count(0)
    assert "0 of 160 tests" in page.locator("#shown").inner_text()
    assert watched.quiet()


def test_tables_that_come_with_the_page_can_be_sorted(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(sample.report(tests=60), tmp_path)
    table = page.locator("#summary table").first
    column = [int(text) for text in table.locator("tbody td:nth-child(2)").all_inner_texts()]
    table.get_by_role("button", name="Passed").click()
    assert [int(text) for text in table.locator("tbody td:nth-child(2)").all_inner_texts()] == sorted(column)
    table.get_by_role("button", name="Passed").click()
    assert [int(text) for text in table.locator("tbody td:nth-child(2)").all_inner_texts()] == sorted(column)[::-1]


def test_figures_at_lines_plans_and_verdicts_lead_to_their_tests(watched: Watched, tmp_path: Path) -> None:
    report = sample.report(tests=30)
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
    assert watched.quiet()


@pytest.mark.parametrize("beside", [False, True])
def test_a_test_has_a_page_of_its_own(
    watched: Watched, tmp_path: Path, beside: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if beside:
        monkeypatch.setattr("pytest_hricdv.report.html.EMBEDDED_BYTES", 1000)
    report = sample.report(tests=60)
    page = watched.open(report, tmp_path, "tests")
    last = report["tests"][-1]
    page.get_by_role("link", name=last["id"]).click()
    page.wait_for_selector("#test .timeline svg")
    words = page.locator("#test").inner_text()
    for text in (last["nodeid"], *last["beliefs"], *last["abstract"], "--hri-suite=rl --hri-seed=0"):
        assert text in words
    lanes = page.locator("#test .timeline svg").first.text_content()
    for lane in ("state", "request", "reading", "leg_held", "R4", "simulated time (s)"):
        assert lane in lanes
    assert "arm_speed (rad/s)" in (page.locator("#test .timeline").text_content() or "")
    page.get_by_role("link", name="← previous").click()
    page.wait_for_function(
        "id => document.querySelector('#test h2').textContent.includes(id)", arg=report["tests"][-2]["id"]
    )
    page.go_back()
    page.wait_for_function("id => document.querySelector('#test h2').textContent.includes(id)", arg=last["id"])
    assert any("details/0001.js" in url for url in watched.asked) == beside
    assert watched.quiet()


def test_a_cell_of_a_heat_map_leads_to_its_tests(watched: Watched, tmp_path: Path) -> None:
    report = sample.report(tests=30)
    page = watched.open(report, tmp_path, "cross")
    page.wait_for_selector("#cross svg [aria-label=cell] a")
    address = page.locator("#cross svg [aria-label=cell] a").first.get_attribute("href")
    *_, across, leg, down, gpl = address.split("/")
    assert (across, down) == ("1", "0")
    page.evaluate("address => { location.hash = address; }", address)
    bins = [sample.GPL[int(gpl)], sample.LEGS[int(leg)]]
    hit = [test["id"] for test in report["tests"] if bins in test["cross"]["handover"]]
    listed(page).to_have_text(hit)
    assert f"that hit leg {bins[1]}, gpl {bins[0]} of handover" in page.locator("#tests .notice").inner_text()
    assert watched.quiet()


def test_actions_have_their_times(watched: Watched, tmp_path: Path) -> None:
    report = sample.report(tests=1)
    report["tests"][0]["acted_s"] = [0.0, 6.25]
    page = watched.open(report, tmp_path, "tests")
    page.locator("#tests td a").first.click()
    page.wait_for_selector("#test .timeline svg")
    times = page.locator("#test .actions tbody td:nth-child(2)").all_inner_texts()
    assert times[:3] == ["0.00 s", "6.25 s", "not done"]
    assert "the human" in (page.locator("#test .timeline svg").first.text_content() or "")


def test_the_smallest_suite_and_what_adds_nothing_are_listed(watched: Watched, tmp_path: Path) -> None:
    report = with_closure(sample.report(tests=10))
    page = watched.open(report, tmp_path, "closure")
    page.wait_for_selector("#closure figure svg")
    page.get_by_role("link", name="These tests").click()
    listed(page).to_have_text([test["id"] for test in report["tests"][:5]])
    page.get_by_role("button", name="Adds").click()
    assert page.locator("#tests tbody td:nth-child(9)").all_inner_texts() == ["4", "5", "6", "7", "8"]
    watched.show("closure")
    page.get_by_role("link", name="tests that add nothing").click()
    listed(page).to_have_text([test["id"] for test in report["tests"][5:]])
    assert watched.quiet()


def test_without_scripts_everything_but_plots_and_tests_can_be_read(browser: Any, tmp_path: Path) -> None:
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    write(sample.report(tests=2), tmp_path)
    page.goto(f"file://{tmp_path}/index.html")
    for view in ("summary", "suites", "closure", "code", "plans"):
        assert page.locator(f"#{view}").is_visible()
    assert "Without scripts this page has no plots" in page.locator("noscript").inner_text()
    context.close()


def test_details_that_are_not_beside_the_page_are_missed_by_name(
    watched: Watched, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pytest_hricdv.report.html.EMBEDDED_BYTES", 1000)
    report = sample.report(tests=3)
    page = watched.open(report, tmp_path, "tests")
    shutil.rmtree(tmp_path / "details")
    page.locator("#tests td a").first.click()
    page.wait_for_selector("#test .notice")
    assert "details/0000.js is missing beside this page" in page.locator("#test").inner_text()
    watched.show("test/nosuchtest")
    assert "There is no such test in this report." in page.locator("#test").inner_text()


def test_a_violation_is_marked_where_it_happened(watched: Watched, tmp_path: Path) -> None:
    report = sample.report(tests=60)
    failed = next(test for test in report["tests"] if test["requirements"]["R3"]["verdict"] == "Failed")
    page = watched.open(report, tmp_path, "requirement/R3")
    page.locator("[id='requirement/R3'] table a", has_text=failed["id"]).first.click()
    page.wait_for_selector("#test .timeline svg")
    assert "violated at 51.5 s: hand_distance = 0.03" in page.locator("#test").inner_text()
    marks = page.locator("#test .timeline svg").first.locator("[aria-label=rule][stroke='var(--bad-mark)'] line")
    assert marks.count() >= 1


@pytest.mark.parametrize(("video", "tag"), [("a.mp4", "video"), ("a.gif", "img")])
def test_a_film_is_shown_with_its_strip(watched: Watched, tmp_path: Path, video: str, tag: str) -> None:
    report = sample.report(tests=2)
    report["tests"][0]["film"] = {
        "video": f"films/{video}",
        "strip": "films/a.png",
        "seconds": 2.0,
        "frames": 24,
        "note": "the replay went another way",
    }
    (tmp_path / "films").mkdir()
    picture = base64.b64decode("R0lGODlhAQABAIAAAAAAAP///yH5BAEAAAAALAAAAAABAAEAAAIBRAA7")
    for name in ("a.png", "a.gif", "a.mp4"):
        (tmp_path / "films" / name).write_bytes(picture)
    page = watched.open(report, tmp_path, "tests")
    page.locator("#tests td a").first.click()
    assert page.locator("#test a img").get_attribute("src") == "films/a.png"
    assert page.locator(f"#test {tag}.film").last.get_attribute("src") == f"films/{video}"
    assert "the replay went another way" in page.locator("#test").inner_text()
    assert watched.quiet()


def test_the_theme_is_chosen_and_kept(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(sample.report(tests=2), tmp_path)
    shade = "() => getComputedStyle(document.body).backgroundColor"
    light = page.evaluate(shade)
    page.get_by_label("Theme").select_option("dark")
    dark = page.evaluate(shade)
    assert dark != light
    page.reload()
    assert page.evaluate(shade) == dark
    page.get_by_label("Theme").select_option("light")
    assert page.evaluate(shade) == light


def test_no_name_becomes_a_script(watched: Watched, tmp_path: Path) -> None:
    report = poisoned()
    page = watched.open(report, tmp_path)
    data = page.evaluate("() => JSON.parse(document.getElementById('data').textContent)")
    links = page.evaluate("() => [...document.querySelectorAll('nav a')].map((link) => link.hash.slice(1))")
    for view in [*links, *(f"test/{row[0]}" for row in data["rows"])]:
        page.evaluate("view => { location.hash = view; }", view)
        page.wait_for_function("() => !document.querySelector('#test').textContent.includes('Loading')")
    watched.show(f"test/{data['rows'][1][0]}")
    page.wait_for_selector("#test .timeline svg")
    words = page.locator("body").inner_text()
    assert "<script>alert(1)</script>" in words
    assert "\u202e" not in words
    assert "\\u{202e}" in words
    assert watched.quiet()


def _unmeasured() -> dict[str, Any]:
    report = sample.report(tests=2)
    report["code_under_test"] = {"measured": False, "reason": "switched off"}
    report["suites"][0]["code"] = {"statements": None, "branches": None}
    for test in report["tests"]:
        test["code"] = None
    return report


def _unchecked() -> dict[str, Any]:
    report = sample.report(tests=2)
    for test in report["tests"]:
        test["requirements"] = {name: sample.judged("NC", 0) for name in test["requirements"]}
        test["timeline"] = None
    return report


def _bare() -> dict[str, Any]:
    report = sample.report(tests=2)
    for test in report["tests"]:
        del test["timeline"], test["plans"]
    return {key: report[key] for key in ("schema", "selected", "reported", "not_run", "suites", "tests")}


@pytest.mark.parametrize(
    "report",
    [sample.report(tests=0), sample.report((), 0), _unmeasured(), _unchecked(), _bare()],
    ids=["no tests", "no suites", "unmeasured", "all NC", "bare"],
)
def test_reports_with_little_in_them_have_quiet_pages(watched: Watched, tmp_path: Path, report: dict[str, Any]) -> None:
    page = watched.open(report, tmp_path)
    links = page.evaluate("() => [...document.querySelectorAll('nav a')].map((link) => link.hash.slice(1))")
    for view in links:
        watched.show(view)
    if report["tests"]:
        watched.show("tests")
        page.locator("#tests td a").first.click()
        page.wait_for_selector("#test .facts")
    assert watched.quiet()
