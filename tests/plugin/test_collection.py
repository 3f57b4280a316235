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


def test_listing_writes_no_report_and_prints_no_section(lamps: pytest.Pytester) -> None:
    result = lamps.runpytest_inprocess("--collect-only", "--hri-suite=rl", "--hri-fail-under=statements=100")
    assert result.ret == 0
    result.stdout.fnmatch_lines(["hri: lamps, suite rl, seed 0, 34 tests"])
    result.stdout.no_fnmatch_line("*= human-robot interaction =*")
    assert not (lamps.path / "hri-report").exists()


def test_number_of_tests_and_of_concretizations(lamps: pytest.Pytester) -> None:
    few = nodeids(lamps.runpytest_inprocess(*COLLECT, "--hri-tests=3"))
    doubled = nodeids(lamps.runpytest_inprocess(*COLLECT, "--hri-tests=3", "--hri-concretizations=2"))
    assert len(few) == 3
    assert len(doubled) == 6
    assert doubled[::2] == few
    assert doubled[1::2] == [nodeid.replace("]", "-k1]") for nodeid in few]


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


def test_a_file_of_bare_commands_is_a_suite(lamps: pytest.Pytester) -> None:
    (lamps.path / "recorded.txt").write_text("enter hall\nset_lamp level=10\n\ngreet  # and nothing else\n")
    listed = nodeids(lamps.runpytest_inprocess("--collect-only", "-q", "--hri-suite=recorded.txt"))
    assert len(listed) == 2
    assert all("[recorded-" in nodeid for nodeid in listed)


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
