"""The suites in the simulated world: every run ends with a defined outcome."""

from __future__ import annotations

from itertools import islice
from pathlib import Path

import pytest

import conftest
from controller import machine
from pytest_hricdv.execution.case import CaseResult
from tests.hri import bench
from tests.hri.user import HOST, pytest_run

OUTCOMES = {"released", "discarded", "no-human-ready", "sensing-timeout"}
ENDS = {"table done", "nobody asks any more"}

SUITES = ("by-hand", "bdi-random", "pseudorandom")
FEW = 3
"""Tests of each suite that are run."""


def assert_whole(result: CaseResult) -> None:
    """Check what holds for every run."""
    assert result.outcome.ended in ENDS
    assert not result.errors
    assert len(result.outcome.outcomes) <= 4
    assert set(result.outcome.outcomes) <= OUTCOMES
    assert len(result.outcome.cross["decision"]) == len(result.outcome.outcomes)
    assert result.sim_s <= bench.LONGEST_S
    assert 0.0 <= result.outcome.skipped_s <= result.sim_s
    assert result.verdict("R4").verdict != "Failed"
    assert len(bench.times(result, "turn_done")) == len(result.outcome.outcomes)
    assert (result.outcome.ended == "table done") == (len(result.outcome.outcomes) == 4)


@pytest.mark.slow
def test_three_suites_run_on_two_workers_and_are_reported(tmp_path: Path) -> None:
    session = pytest_run(tmp_path, HOST, "--hri-suite=by-hand,bdi-random,pseudorandom", "--hri-tests=3", "-n", "2")
    assert session.code == 0, session.output
    assert session.report["selected"] == session.report["reported"] == 9
    assert [suite["name"] for suite in session.report["suites"]] == ["by-hand", "bdi-random", "pseudorandom"]
    for suite in session.report["suites"]:
        entries = [test for test in session.report["tests"] if test["suite"] == suite["name"]]
        assert len(entries) == 3
        for verdicts in suite["requirements"].values():
            assert verdicts["passed"] + verdicts["failed"] + verdicts["nc"] == 3
    for test in session.report["tests"]:
        assert set(test["outcomes"]) <= OUTCOMES
        assert test["sim_s"] <= bench.LONGEST_S
        assert test["outcome"] in ("passed", "known-violation")


@pytest.mark.slow
@pytest.mark.parametrize("name", SUITES)
def test_every_run_of_a_suite_ends_with_a_defined_outcome(name: str) -> None:
    for test in islice(bench.suite(name, seed=5), FEW):
        assert_whole(bench.run(test))


def test_four_good_legs_make_a_table_on_time() -> None:
    result = bench.run(bench.concrete(bench.leg() * 4, seed=4))
    assert_whole(result)
    assert result.outcome.ended == "table done"
    (done,) = [message.fields for message in result.record.messages if message.topic == "table_done"]
    assert result.outcome.outcomes == ("released",) * 4
    assert done["released"] == 4
    assert done["on_time"] is True
    assert done["duration_s"] == pytest.approx(result.sim_s)


def test_a_run_that_ends_at_the_limit_is_a_fault_of_a_robot_that_never_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(machine.TRANSITIONS, ("Receive1", "timeout"), "Receive1")
    result = bench.run(bench.concrete(bench.leg()))
    assert result.outcome.outcomes == ("released",)
    assert result.sim_s == pytest.approx(conftest.LIMIT_S)
    assert result.errors == (
        'the run ended at its time limit of 900 s; if it may, declare VirtualTime(allowed_endings=("limit",))',
    )
