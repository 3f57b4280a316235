"""Shards, and what is done with reports afterwards: merge, gates, and what is wrong with a report."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

from tests.plugin.conftest import SessionRunner
from tests.plugin.project import A_WORKER, change, command, counted_up_to_313, plain_and_slowly_on_a_worker, report

RL = "--hri-suite=rl"


def shards(lamps: pytest.Pytester, of: int, *options: str) -> list[str]:
    """Run each shard into a folder of its own."""
    folders = []
    for index in range(1, of + 1):
        folders.append(f"part{index}")
        result = lamps.runpytest_inprocess(RL, f"--hri-shard={index}/{of}", f"--hri-report={folders[-1]}", *options)
        assert result.ret == 0
    return folders


def read(folder: Path) -> dict[str, Any]:
    loaded: dict[str, Any] = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    return loaded


def timeless(report: dict[str, Any]) -> dict[str, Any]:
    """What must not depend on how a suite was split up, nor on the folder that a report was written into."""
    suites = [{key: value for key, value in suite.items() if key != "generation"} for suite in report["suites"]]
    tests = [{key: value for key, value in test.items() if key not in ("wall_s", "replay")} for test in report["tests"]]
    keys = ("selected", "reported", "not_run", "requirements", "code_under_test", "models", "cross_products")
    return {key: report[key] for key in keys} | {"suites": suites, "tests": tests}


def decided(result: subprocess.CompletedProcess[str]) -> list[str]:
    """How many tests a command merged, and what failed, without the verdict at the end."""
    lines = result.stdout.splitlines()
    return [line for line in lines if " tests merged" in line or (line.startswith("FAILED ") and line[7] != " ")]


@pytest.mark.slow
@plain_and_slowly_on_a_worker
def test_the_merged_shards_are_the_whole_run(lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
    parts = shards(lamps, 3, *options)
    assert lamps.runpytest_inprocess(RL).ret == 0
    merged = command("merge", *parts, "-o", "all")
    assert merged.returncode == 0, merged.stdout + merged.stderr
    assert merged.stdout.splitlines()[0] == "all: merged from 3 reports of 3 runs"
    assert decided(merged) == ["34/34 tests merged"]
    assert timeless(read(lamps.path / "all")) == timeless(report(lamps.path))
    sizes = [read(lamps.path / part)["selected"] for part in parts]
    assert sum(sizes) == 34
    assert min(sizes) > 0
    written = {name: (lamps.path / "all" / name).read_bytes() for name in ("report.json", "index.html")}
    again = command("merge", *reversed(parts), parts[0], "-o", "all")
    assert again.returncode == 0
    assert {name: (lamps.path / "all" / name).read_bytes() for name in written} == written


@pytest.fixture
def parts(after: SessionRunner) -> list[str]:
    """The folders of both halves of the suite rl, of the unchanged project."""
    for index in (1, 2):
        after(RL, f"--hri-shard={index}/2", f"--hri-report=part{index}")
    return ["part1", "part2"]


@pytest.mark.slow
def test_a_missing_shard_is_told_and_fails(lamps: pytest.Pytester, after: SessionRunner) -> None:
    first, second = "part1", "part2"
    for index in (1, 2):
        after(RL, f"--hri-shard={index}/3", f"--hri-report=part{index}")
    merged = command("merge", first, second)
    assert merged.returncode == 1
    counted = sum(read(lamps.path / part)["selected"] for part in (first, second))
    assert decided(merged) == [
        f"{counted}/34 tests merged",
        "FAILED shard 3/3 is missing",
        f"FAILED {34 - counted} of 34 tests have no result: totals are lower bounds",
    ]
    assert read(lamps.path / "hri-merged")["gates"]["failed"][0] == "shard 3/3 is missing"


@pytest.mark.slow
@counted_up_to_313
def test_gates_are_for_the_merged_report(lamps: pytest.Pytester) -> None:
    change(lamps.path, "pytest.ini", "pythonpath = .", "pythonpath = .\nhri_fail_under = plans=100")
    parts = shards(lamps, 3, "--hri-fail-under=cross=100", "--hri-fail-on-nc")
    command("merge", *parts, "-o", "all")
    good = command("gate", "all", "--fail-under=cross=100", "--fail-under=plans=100", "--fail-on-nc")
    assert (good.returncode, decided(good)) == (0, ["34/34 tests merged"])
    bad = command("merge", *parts, "--fail-under=statements=98", "-o", "all")
    assert bad.returncode == 1
    assert "FAILED suite rl: statements 97.56 %, at least 98 % asked for" in bad.stdout
    unknown = command("gate", "all", "--fail-under=lines=98")
    assert unknown.returncode == 2
    assert "lines=98: expected KIND=PCT with KIND in statements," in unknown.stderr


@pytest.mark.slow
def test_a_merged_report_is_a_baseline_and_is_held_against_one(lamps: pytest.Pytester, parts: list[str]) -> None:
    assert command("merge", *parts, "--baseline=base.json", "--update-baseline").returncode == 0
    assert lamps.runpytest_inprocess(RL, "--hri-baseline=base.json").ret == 0
    same = command("gate", "hri-merged", "--baseline=base.json")
    assert same.returncode == 0
    assert "all 34 tests behave as in the baseline" in same.stdout
    base = json.loads((lamps.path / "base.json").read_text(encoding="utf-8"))
    base["suites"]["rl"]["violations"]["R2"].pop()
    (lamps.path / "base.json").write_text(json.dumps(base), encoding="utf-8")
    worse = command("gate", "hri-merged", "--baseline=base.json")
    assert worse.returncode == 1
    assert "FAILED suite rl: R2 is newly violated by rl-hall-" in worse.stdout
    partly = command("merge", parts[0], "--baseline=base.json", "--update-baseline")
    assert "FAILED base.json was not updated: tests are missing" in partly.stdout
    nameless = command("gate", "hri-merged", "--update-baseline")
    assert (nameless.returncode, nameless.stderr) == (
        2,
        "error: --update-baseline: say which file, with --baseline=FILE\n",
    )


@pytest.mark.slow
def test_code_that_changed_between_runs_is_refused(lamps: pytest.Pytester, after: SessionRunner) -> None:
    after(RL, "--hri-shard=1/2", "--hri-report=part1")
    change(lamps.path, "lamps/guide.py", "return 10.0", "return 11.0")
    lamps.runpytest_inprocess(RL, "--hri-shard=2/2", "--hri-report=part2")
    merged = command("merge", "part1", "part2")
    assert merged.returncode == 2
    assert merged.stderr == "error: part1 and part2: different code under test: lamps/guide.py; run both again\n"
    assert not (lamps.path / "hri-merged").exists()


@pytest.mark.slow
def test_a_crashed_run_and_its_repetition_make_a_whole(lamps: pytest.Pytester) -> None:
    change(lamps.path, "conftest.py", "LIMIT_S = 60.0\n", "LIMIT_S = 60.0\nCRASH = True\n")
    condition = 'CRASH and any(action.command.endswith("= 10") for action in run.test.actions)'
    crash = f'    if {condition}:\n        __import__("os").kill(__import__("os").getpid(), 9)\n'
    change(lamps.path, "conftest.py", "    from lamps import guide\n", f"{crash}    from lamps import guide\n")
    lamps.runpytest_inprocess("--hri-suite=by-hand", *A_WORKER, "--hri-report=crashed")
    alone = command("merge", "crashed")
    assert alone.returncode == 1
    assert "3/4 tests merged" in alone.stdout
    change(lamps.path, "conftest.py", "CRASH = True", "CRASH = False")
    lamps.runpytest_inprocess("--hri-suite=by-hand", "--hri-report=whole")
    both = command("merge", "crashed", "whole")
    assert (both.returncode, decided(both)) == (0, ["4/4 tests merged"])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        (lambda text: text[:5000], "not JSON, perhaps cut off"),
        (lambda text: text.replace("hricdv-report/3", "hricdv-report/9"), "expected schema 'hricdv-report/3', found"),
        (
            lambda text: text.replace('"outcome"', '"result"'),
            "missing required field `outcome` - at `$.tests[0]`",
        ),
        (
            lambda text: text.replace('"map"', '"plan"'),
            "`map` - at `$.code_under_test`; run the suite again",
        ),
        (lambda text: "", "not JSON"),
    ],
)
def test_a_report_that_cannot_be_used_is_told_by_file(
    lamps: pytest.Pytester, after: SessionRunner, spoil: Any, told: str
) -> None:
    after("--hri-suite=by-hand", "-q")
    path = lamps.path / "hri-report" / "report.json"
    path.write_text(spoil(path.read_text(encoding="utf-8")), encoding="utf-8")
    merged = command("merge", "hri-report")
    assert merged.returncode == 2
    assert merged.stderr.startswith("error: hri-report")
    assert told in merged.stderr
    assert len(merged.stderr.splitlines()) == 1


@pytest.mark.parametrize("given", ["0/3", "4/3", "1", "a/b", "1/0", "-1/3", "1/3/5", "١/٣", "1/10000", "1/99999999"])
def test_a_shard_that_makes_no_sense_is_refused(lamps: pytest.Pytester, given: str) -> None:
    result = lamps.runpytest_inprocess(RL, f"--hri-shard={given}")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"ERROR: --hri-shard={given}: expected INDEX/OF, as in 1/3, with INDEX from 1 to OF*"])
