"""The report that a session writes: the typed model reads all of it, and writes the same bytes."""

from __future__ import annotations

import json

import pytest

from pytest_hricdv.extra.search.records import SEARCH, SHRUNK
from pytest_hricdv.results.codec import canonical, load
from pytest_hricdv.results.model import Report
from tests import json_schema
from tests.plugin.conftest import FinishedSession, SessionRunner
from tests.plugin.project import change

SUITE = "--hri-suite=by-hand"


def reread(session: pytest.Pytester | FinishedSession) -> Report:
    """The report, after a check that it is written as it was read."""
    path = session.path / "hri-report" / "report.json"
    text = path.read_text(encoding="ascii")
    report = load(path)
    assert canonical(report) == text
    json_schema.REPORT.validate(json.loads(text))
    return report


@pytest.mark.slow
def test_a_learned_suite(finished: SessionRunner) -> None:
    report = reread(finished("--hri-suite=rl"))
    assert [suite.name for suite in report.suites] == ["rl"]
    assert report.tests[0].outcomes == ("released",)
    assert report.gates is not None


def test_a_shard_that_was_stopped_by_an_error(lamps: pytest.Pytester) -> None:
    change(lamps.path, "conftest.py", "ended = run.go(", "ended = run.stay(")
    lamps.runpytest_inprocess(SUITE, "-x", "--hri-shard=1/1", "--hri-no-cov")
    report = reread(lamps)
    assert report.shard == "1/1"
    assert report.gates is None
    (broken,) = [test for test in report.tests if test.outcome == "error"]
    assert (broken.action_times_s, broken.record_sha256, broken.timeline) == (None, None, None)
    assert not broken.requirements["R1"].near_miss


@pytest.mark.slow
def test_failures_that_are_shrunk_searched_and_replayed(lamps: pytest.Pytester) -> None:
    lamps.runpytest_inprocess(SUITE, "--hri-strict", "--hri-shrink", "--hri-search=4")
    report = reread(lamps)
    assert set(SEARCH.of(report)) == {"R1", "R2", "R3"}
    (failed,) = [test for test in report.tests if SHRUNK.of(test)]
    assert failed.replay is not None
    lamps.runpytest_inprocess(f"--hri-replay={failed.replay}")
    (replayed,) = reread(lamps).tests
    assert replayed.replayed is not None
    assert replayed.replayed.same
