"""The page in a browser: no network, no errors, and legible."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from pytest_hricdv.extra.traces.records import TraceResult
from pytest_hricdv.report.files import write
from tests.report import sample, sample_sections
from tests.report.test_html import poisoned
from tests.report.watched import Watched

CUT_OFF = """() => [...document.querySelectorAll("main .scroll:not(.plot)")]
  .filter((place) => place.checkVisibility() && place.scrollWidth > place.clientWidth)
  .map((place) => place.outerHTML.slice(0, 120))"""

VIEWS = [
    "summary",
    "suites",
    "closure",
    "requirement/R1",
    "requirement/R3",
    "code",
    "plans",
    "cross",
    "mutants",
    "tests",
]

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


@pytest.mark.parametrize("scheme", ["light", pytest.param("dark", marks=pytest.mark.slow)])
@pytest.mark.parametrize("width", [1280, pytest.param(390, marks=pytest.mark.slow)])
def test_every_view_is_legible_on_screens_of_any_kind(browser: Any, tmp_path: Path, scheme: Any, width: int) -> None:
    watched = Watched(browser, viewport={"width": width, "height": 800}, color_scheme=scheme)
    report = sample.data(("by-hand", "rl"), 12) | {
        "mutation": sample_sections.MUTATION,
        "closing": sample_sections.CLOSING,
    }
    page = watched.open(report, tmp_path)
    test = page.evaluate("() => JSON.parse(document.getElementById('data').textContent).rows[0][0]")
    for view in [*VIEWS, f"test/{test}"]:
        watched.show(view)
        if view.startswith("test/"):
            page.wait_for_selector("#test .timeline svg")
        assert page.evaluate("document.documentElement.scrollWidth") <= width, f"{view} is wider than the screen"
        assert page.evaluate(CUT_OFF) == [], f"{view} has to be scrolled sideways"
        assert page.evaluate(CONTRAST) == [], view
        page.screenshot(path=tmp_path / f"{view.replace('/', '-')}.png")
    watched.assert_quiet()
    page.context.close()


def test_plots_have_axes_with_units_and_legends(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(sample.data(("by-hand", "rl"), 12), tmp_path, "suites")
    assert page.locator("#suites figure svg[aria-label]").count() == 5
    words = page.locator("#suites").text_content()
    for text in ("tests run →", "statements covered (%)", "iteration →", "largest change of Q"):
        assert text in words
    assert page.locator("#suites figure .legend li").count() == 9  # learning is of one suite only
    watched.show("requirement/R1")
    words = page.locator("[id='requirement/R1']").text_content()
    assert "simulated time (s) →" in words
    assert "margin (s) →" in words
    watched.assert_quiet()


def test_without_scripts_everything_but_plots_and_tests_can_be_read(browser: Any, tmp_path: Path) -> None:
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    write(sample.report(tests=2), tmp_path)
    page.goto(f"file://{tmp_path}/index.html")
    for view in ("summary", "suites", "closure", "code", "plans"):
        assert page.locator(f"#{view}").is_visible()
    assert "Without scripts this page has no plots" in page.locator("noscript").inner_text()
    context.close()


@pytest.mark.slow
def test_no_name_becomes_a_script(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(poisoned(), tmp_path)
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
    watched.assert_quiet()


HANDLER = '<img src="missing.png" onerror="document.title = \'ran\'">'


def test_nothing_but_the_pages_own_scripts_runs(watched: Watched, tmp_path: Path) -> None:
    page = watched.open(sample.data(tests=2), tmp_path)
    page.evaluate("html => document.body.insertAdjacentHTML('beforeend', html)", HANDLER)
    page.evaluate(
        """() => {
          document.body.insertAdjacentHTML("beforeend", "<a id=evil href=\\"javascript:document.title='ran'\\">x</a>");
          const script = document.createElement("script");
          script.textContent = "document.title = 'ran'";
          document.body.append(script);
          document.getElementById("evil").click();
        }"""
    )
    page.wait_for_function("() => document.querySelector('img[onerror]').complete")
    page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    assert page.title() != "ran"
    refused = [text for text in watched.errors if "Content Security Policy" in text]
    assert len(refused) == 3, watched.errors


LEADING_OUT = ("javascript:alert(1)", "java\nscript:alert(1)", "//host/a", "/etc", "../a.mp4", "films/../../a", "a\\b")


def test_no_address_on_the_page_leads_out_of_its_folder(watched: Watched, tmp_path: Path) -> None:
    report = sample.typed(sample.data(tests=len(LEADING_OUT)))
    traces = [TraceResult(file=address, bag="traces/a.mcap") for address in LEADING_OUT]
    tests = tuple(replace(test, trace=trace) for test, trace in zip(report.tests, traces, strict=True))
    page = watched.open(replace(report, tests=tests), tmp_path)
    leading = "() => [...document.querySelectorAll('a[href]')].map((link) => link.getAttribute('href'))"
    for row in page.evaluate("() => JSON.parse(document.getElementById('data').textContent).rows"):
        watched.show(f"test/{row[0]}")
        page.wait_for_function("anchor => document.getElementById('test').dataset.test === anchor", arg=row[0])
        page.wait_for_selector("#test a[href='traces/a.mcap']")
        assert [link for link in page.evaluate(leading) if not link.startswith("#")] == ["traces/a.mcap"]
    watched.assert_quiet()
