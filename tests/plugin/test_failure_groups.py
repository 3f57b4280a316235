"""Violations by situation."""

from __future__ import annotations

import pytest

from pytest_hricdv.report.verdict import failure_groups
from pytest_hricdv.results.codec import load
from tests.plugin.conftest import SessionRunner
from tests.plugin.project import change

SUITE = ("--hri-suite=rl", "-p", "no:xdist")


@pytest.mark.slow
def test_tests_that_fail_for_the_same_reason_are_one_group(finished: SessionRunner) -> None:
    folder = finished("--hri-suite=rl").path / "hri-report"
    report = load(folder)
    (group,) = failure_groups(report)
    failing = {test.id for test in report.tests if test.requirements["R2"].verdict == "Failed"}
    assert (group.requirement, group.is_known, {test.id for test in group.tests}) == ("R2", True, failing)
    assert group.margin == min(test.requirements["R2"].margin or 0.0 for test in report.tests)
    assert group.tests[0].requirements["R2"].margin == group.margin
    assert "Known violations" in (folder / "index.html").read_text(encoding="utf-8")


def test_what_is_not_known_comes_first(lamps: pytest.Pytester) -> None:
    change(lamps.path, "lamps/guide.py", "            bus.publish(Answer())\n", "            pass\n")
    lamps.runpytest_inprocess(*SUITE)
    groups = failure_groups(load(lamps.path / "hri-report"))
    assert [(group.requirement, group.is_known) for group in groups] == [("R3", False), ("R2", True)]


def test_without_violations_there_are_none(lamps: pytest.Pytester) -> None:
    lamps.runpytest_inprocess(*SUITE, "-k", "cellar")
    assert failure_groups(load(lamps.path / "hri-report")) == ()
    assert "Known violations" not in (lamps.path / "hri-report" / "index.html").read_text(encoding="utf-8")
