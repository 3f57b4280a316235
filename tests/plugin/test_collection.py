"""Collecting: what `--collect-only` lists, and where the tests come from."""

from __future__ import annotations

import re

import pytest

from tests.plugin.project import MODES, change, nodeids, report

ID = re.compile(r"test_lamps\.py::test_lamps\[rl-(hall|cellar)(-polite)?(-curt)?-[0-9a-f]{8}\]")
COLLECT = ("--collect-only", "-q", "--hri-suite=rl")


@pytest.mark.slow
def test_ids_are_the_same_in_every_mode(lamps: pytest.Pytester) -> None:
    listed = nodeids(lamps.runpytest_inprocess(*COLLECT))
    assert len(listed) == len(set(listed)) > 20
    assert all(ID.fullmatch(line) for line in listed)
    assert nodeids(lamps.runpytest_inprocess(*COLLECT, *MODES["without xdist"])) == listed
    assert nodeids(lamps.runpytest_subprocess(*COLLECT, *MODES["on two workers"])) == listed


def test_the_second_collection_comes_from_the_cache(lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pytest_hricdv.session.collection._LONG_S", 0.0)
    learning = "hricdv: generating suite rl (seed 0): iteration 1 of *, * model runs"
    lamps.runpytest_inprocess("--collect-only", "--hri-suite=rl").stdout.fnmatch_lines([learning])
    lamps.runpytest_inprocess("--collect-only", "--hri-suite=rl").stdout.no_fnmatch_line(learning)
    uncached = lamps.runpytest_inprocess("--collect-only", "--hri-suite=rl", "-p", "no:cacheprovider")
    uncached.stdout.fnmatch_lines([learning])


@pytest.mark.parametrize(
    ("selection", "suites"),
    [
        ("by-hand,rl", {"by-hand", "rl"}),
        ("all", {"by-hand", "bdi-random", "rl", "pseudorandom"}),
        ("rl,rl", {"rl"}),
    ],
)
def test_several_suites(lamps: pytest.Pytester, selection: str, suites: set[str]) -> None:
    listed = nodeids(lamps.runpytest_inprocess("--collect-only", "-q", f"--hri-suite={selection}", "--hri-tests=4"))
    assert len(listed) == len(set(listed)) == 4 * len(suites)
    assert {suite for suite in suites for line in listed if f"[{suite}-" in line} == suites


@pytest.mark.slow
def test_all_takes_the_suites_that_the_testbench_has_everything_for_and_says_so(lamps: pytest.Pytester) -> None:
    change(lamps.path, "conftest.py", '        suites=Suites(by_hand=HERE / "by_hand.toml"),\n', "")
    result = lamps.runpytest("--hri-suite=all", "--hri-tests=2")
    result.stdout.fnmatch_lines(
        ["hricdv: suite all is without by-hand: the testbench names no file of belief subsets (by_hand)"]
    )
    assert {suite["name"] for suite in report(lamps.path)["suites"]} == {"bdi-random", "rl", "pseudorandom"}
    refused = lamps.runpytest("--hri-suite=all,by-hand")
    refused.stderr.fnmatch_lines(["*tests by hand need a file of belief subsets, but the testbench names none*"])
