"""Films, timelines and links in the reports of Allure and of pytest-html."""

from __future__ import annotations

import base64
import json
import random
import re
from html import unescape
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from pytest_hricdv.report.tests_view import anchor
from pytest_hricdv.session.exports import timeline_text
from tests.plugin.project import A_WORKER, report
from tests.report import sample_tests

SUITE = ("--hri-suite=by-hand", "--hri-strict")


@pytest.fixture
def bench(lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    monkeypatch.delenv("PYTEST_ADDOPTS")
    return lamps


def results(folder: Path) -> dict[str, dict[str, Any]]:
    """Allure's result of each test, by its name."""
    found = (json.loads(path.read_text("utf-8")) for path in folder.glob("*-result.json"))
    return {each["name"]: each for each in found}


@pytest.mark.slow
@pytest.mark.parametrize("options", [("-p", "no:xdist"), A_WORKER], ids=["plain", "on a worker"])
def test_allure_gets_a_timeline_and_a_link_of_each_test(bench: pytest.Pytester, options: tuple[str, ...]) -> None:
    bench.runpytest_subprocess(*SUITE, "--alluredir=out/allure", *options)
    folder = bench.path / "out" / "allure"
    found, tests = results(folder), report(bench.path)["tests"]
    assert len(found) == len(tests) > 2
    for test in tests:
        mine = found[test["nodeid"].partition("::")[2]]
        assert [link["url"] for link in mine["links"]] == [f"../../hri-report/index.html#test/{anchor(test['nodeid'])}"]
        attached = {each["name"]: folder / each["source"] for each in mine["attachments"]}
        text = attached["timeline"].read_text("utf-8")
        for message in test["timeline"]["messages"]:
            assert message.split("\t")[2] in text
        assert ("FAILED" in text) == any(each["violations"] for each in test["requirements"].values())
        times = [float(line.split()[0]) for line in text.splitlines()]
        assert times == sorted(times)


@pytest.mark.slow
@pytest.mark.parametrize(("options", "contained"), [(("-p", "no:xdist"), False), (A_WORKER, True)])
def test_pytest_html_gets_a_timeline_and_a_link_of_each_test(
    bench: pytest.Pytester, options: tuple[str, ...], contained: bool
) -> None:
    given = ("--self-contained-html",) if contained else ()
    bench.runpytest_subprocess(*SUITE, "--html=out/tests.html", *given, *options)
    page = (bench.path / "out" / "tests.html").read_text("utf-8")
    blob = re.search(r'data-jsonblob="([^"]*)"', page)
    assert blob is not None
    shown = json.loads(unescape(blob[1]))["tests"]
    tests = report(bench.path)["tests"]
    assert len(tests) > 2
    for test in tests:
        extras = {each["name"]: each["content"] for each in shown[test["nodeid"]][0]["extras"]}
        assert extras["pytest-hricdv"] == f"../hri-report/index.html#test/{anchor(test['nodeid'])}"
        text = extras["timeline"]
        if contained:
            text = base64.b64decode(text.partition("base64,")[2]).decode()
        else:
            text = (bench.path / "out" / text).read_text("utf-8")
        assert test["timeline"]["messages"][0].split("\t")[2] in text


@pytest.mark.slow
def test_without_their_options_nothing_is_written(bench: pytest.Pytester) -> None:
    bench.runpytest_subprocess(*SUITE, "-p", "no:cacheprovider")
    assert [str(page.relative_to(bench.path)) for page in bench.path.rglob("*.html")] == ["hri-report/index.html"]
    assert not list(bench.path.rglob("*-result.json"))


def test_the_timeline_as_text_says_what_is_pending_where_the_run_ended() -> None:
    test = sample_tests.result(random.Random(1))
    assert test.timeline is not None
    test = replace(test, timeline=replace(test.timeline, triggers={"R5": "1-2 41.25-60?"}))
    lines = timeline_text(test, {}).splitlines()
    assert [line.split() for line in lines if "R5" in line] == [
        ["60.000", "R5", "pending,", "triggered", "at", "41.25", "s"]
    ]
