"""What a change of the code did: tests that behave differently from the baseline, and the gate for it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests import json_schema
from tests.plugin.conftest import SessionRunner
from tests.plugin.project import change, command, report

BASE = "--hri-baseline=base.json"
BY_HAND = ("--hri-suite=by-hand", "-q", BASE)
GATE = "--hri-fail-on-change"


@pytest.fixture
def kept(lamps: pytest.Pytester, after: SessionRunner) -> pytest.Pytester:
    """The lamps project with a baseline of the suite by-hand."""
    after(*BY_HAND, "--hri-update-baseline")
    return lamps


def slower(lamps: pytest.Pytester) -> None:
    """Let the lamp be switched 0.2 s later: nothing that a requirement asks for."""
    change(lamps.path, "lamps/guide.py", "SWITCHING_S = 0.3", "SWITCHING_S = 0.5")


def edit(folder: Path, **changes: Any) -> None:
    """Change the suite's part of the baseline; None removes a key."""
    base = json.loads((folder / "base.json").read_text(encoding="utf-8"))
    base["suites"]["by-hand"].update(changes)
    suite = {name: value for name, value in base["suites"]["by-hand"].items() if value is not None}
    (folder / "base.json").write_text(json.dumps({**base, "suites": {"by-hand": suite}}), encoding="utf-8")


@pytest.mark.slow
def test_the_same_code_behaves_as_in_the_baseline(kept: pytest.Pytester) -> None:
    result = kept.runpytest_inprocess("-vv", *BY_HAND, GATE)
    assert result.ret == 0
    result.stdout.fnmatch_lines(["all 4 tests behave as in the baseline", "PASSED *"])
    assert report(kept.path)["changes"] == {
        "compared": 4,
        "changed": {},
        "kinds": [],
        "new": [],
        "removed": [],
        "notes": [],
    }


@pytest.mark.slow
def test_a_change_that_no_requirement_minds_is_listed_by_kind(kept: pytest.Pytester) -> None:
    slower(kept)
    change(kept.path, "lamps/guide.py", "        return GLARE\n", "        return 70.0\n")
    result = kept.runpytest_inprocess("-vv", *BY_HAND, "--hri-summary=summary.md")
    assert result.ret == 0
    result.stdout.fnmatch_lines(
        [
            "4 of 4 tests behave differently from the baseline",
            "  3  `switched` later",
            "     first difference in by-hand-hall-curt-*: at 1.8 s",
            "     `switched(level=10)`, 0.2 s later than before",
            "  1  `switched` with another `level`",
            "     first difference in by-hand-cellar-polite-*: at 2.5 s",
            "     `switched(level=70)` instead of `switched(level=80)` at 2.3 s",
        ]
    )
    json_schema.REPORT.validate(report(kept.path))
    changes = report(kept.path)["changes"]
    assert [(each["kind"], each["tests"]) for each in changes["kinds"]] == [
        ("`switched` later", 3),
        ("`switched` with another `level`", 1),
    ]
    (other,) = (each for each in changes["changed"].values() if each["kind"] == changes["kinds"][1]["kind"])
    assert other["also"] == ["margin of R1 0.5 instead of 0.7", "margin of R2 10 instead of 0"]
    assert [message[2] for message in other["before"]["messages"]] == ["greeting", "wish", "answer", "switched"]
    summary = (kept.path / "summary.md").read_text(encoding="utf-8")
    told = "Behaviour: 4 of 4 tests behave differently from the baseline; first difference in by-hand-hall-curt-"
    assert told in summary


@pytest.mark.slow
def test_the_gate_fails_a_run_that_behaves_otherwise(kept: pytest.Pytester) -> None:
    slower(kept)
    change(kept.path, "pytest.ini", "pythonpath = .", "pythonpath = .\nhri_fail_on_change = true")
    result = kept.runpytest_inprocess(*BY_HAND)
    assert result.ret == 1
    result.assert_outcomes(passed=3, xfailed=1)
    result.stdout.fnmatch_lines(["FAILED 4 of 4 tests behave differently from the baseline"])
    part = kept.runpytest_inprocess(*BY_HAND, "-k", "cellar")
    assert part.ret == 1
    part.stdout.fnmatch_lines(["FAILED 1 of 1 tests behaves differently from the baseline"])
    accepted = kept.runpytest_inprocess(*BY_HAND, "--hri-update-baseline")
    assert accepted.ret == 0
    assert kept.runpytest_inprocess(*BY_HAND).ret == 0


def test_a_baseline_of_an_older_version_still_compares_verdicts_and_says_what_it_lacks(kept: pytest.Pytester) -> None:
    edit(
        kept.path, tests=None, seed=None, code_sha256=None, environment=None, violations={"R1": [], "R2": [], "R3": []}
    )
    result = kept.runpytest_inprocess(*BY_HAND)
    assert result.ret == 1
    result.stdout.fnmatch_lines(
        [
            "the behaviour of no test was compared with the baseline",
            "  the baseline has no behaviour of suite by-hand, because an older version wrote*",
            "FAILED suite by-hand: R2 is newly violated by by-hand-hall-polite-*",
        ]
    )
    assert report(kept.path)["changes"]["new"] == []
    gated = kept.runpytest_inprocess(*BY_HAND, GATE)
    assert gated.ret == pytest.ExitCode.USAGE_ERROR
    gated.stderr.fnmatch_lines(
        ["ERROR: --hri-baseline: *base.json: an older version wrote it, without the behaviour *"]
    )


@pytest.mark.slow
def test_each_shard_and_the_merged_report_are_compared(kept: pytest.Pytester) -> None:
    slower(kept)
    parts = [f"part{index}" for index in (1, 2)]
    for index, part in enumerate(parts, 1):
        result = kept.runpytest_inprocess(*BY_HAND, GATE, f"--hri-shard={index}/2", f"--hri-report={part}")
        assert result.ret == 0  # gates are those of the merged report
        result.stdout.fnmatch_lines(["* behave* differently from the baseline"])
        result.stdout.no_fnmatch_line("*only in the baseline*")
    merged = command("merge", *parts, BASE.replace("hri-", ""), "--fail-on-change", "-o", "all")
    assert merged.returncode == 1
    assert "\n4 of 4 tests behave differently from the baseline\n  4  `switched` later\n" in merged.stdout
    assert "\nFAILED 4 of 4 tests behave differently from the baseline\n" in merged.stdout
    together = json.loads((kept.path / "all" / "report.json").read_text(encoding="utf-8"))
    assert len(together["changes"]["changed"]) == 4
    assert "environment" in together
    without = command("gate", "all", "--fail-on-change")
    assert (without.returncode, without.stderr) == (
        2,
        "error: --fail-on-change: compared with what? give --baseline=FILE\n",
    )
    edit(kept.path, seed=3)
    other = command("gate", "all", "--baseline=base.json")
    assert other.returncode == 2
    assert other.stderr.startswith("error: base.json: of suite by-hand with seed 3; this run has seed 0")


def test_without_a_baseline_the_session_before_is_compared(lamps: pytest.Pytester) -> None:
    first = lamps.runpytest_inprocess("--hri-suite=by-hand")
    lamps.runpytest_inprocess("--hri-suite=by-hand")
    assert report(lamps.path).get("changes") is None  # all the same, as at the first time
    first.stdout.no_fnmatch_line("*the session before*")
    change(lamps.path, "lamps/guide.py", "SWITCHING_S = 0.3", "SWITCHING_S = 0.5")
    result = lamps.runpytest_inprocess("--hri-suite=by-hand")
    result.stdout.fnmatch_lines(["4 of 4 tests behave differently from the session before", "PASSED *"])
    assert result.ret == 0
    changes = report(lamps.path)["changes"]
    assert changes["against"] == "session before"
    assert changes["new"] == changes["removed"] == []
    one, _other = sorted(changes["changed"])[:2]
    lamps.runpytest_inprocess(one, "--hri-suite=by-hand")
    assert report(lamps.path).get("changes") is None
    change(lamps.path, "lamps/guide.py", "SWITCHING_S = 0.5", "SWITCHING_S = 0.3")
    lamps.runpytest_inprocess(one, "--hri-suite=by-hand")
    assert list(report(lamps.path)["changes"]["changed"]) == [one]
    lamps.runpytest_inprocess("--hri-suite=by-hand", "--hri-seed=1")
    assert report(lamps.path).get("changes") is None  # nothing can be compared
