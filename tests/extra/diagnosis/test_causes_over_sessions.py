"""Causes have names that last: baselines and trends say which are new, which were there before, and which are gone."""

from __future__ import annotations

from pathlib import Path

import pytest
from msgspec.structs import replace

from pytest_hricdv.extra.diagnosis.records import CAUSES, DIAGNOSIS, Cause, Diagnosis, failure_causes
from pytest_hricdv.extra.trend.feature import HistoryEntry, compare_causes
from pytest_hricdv.report.failing_tests import FailingTests
from pytest_hricdv.results.baseline import Baseline, baseline_of, read_baseline, write_baseline
from pytest_hricdv.results.gate_check import compare
from pytest_hricdv.results.model import GateResult, Report
from pytest_hricdv.results.origin import ReportOrigin
from tests.extra.diagnosis.test_diagnosis_sessions import SUITE, surging  # noqa: F401 (a fixture)
from tests.plugin.project import change
from tests.report import sample

REPORT = sample.report(tests=3)
ORIGIN = ReportOrigin(began="2026-11-20T08:00:00+00:00", command=("pytest",), revision="", dirty=False)


def report_with(*names: str, known: str = "", began: str = "2026-11-20") -> Report:
    """A report with causes of these ids."""
    ids = tuple(test.id for test in REPORT.tests)
    causes = tuple(Cause(id=name, requirements=("R1",), tests=ids, is_known=name == known) for name in names)
    tests = tuple(replace(test, outcome="failed") for test in REPORT.tests) if names else REPORT.tests
    report = replace(REPORT, tests=tests, origin=replace(ORIGIN, began=f"{began}T08:00:00+00:00"))
    report = DIAGNOSIS.put(report, Diagnosis(runs=0, budget=2, end_reason="done")) if names else report
    return CAUSES.put(report, causes)


def differences(before: Report, now: Report, path: Path) -> list[tuple[str, bool]]:
    write_baseline(baseline_of(before), path)
    baseline: Baseline = read_baseline(path, before.testbench)
    return [(each.text, each.worse) for each in compare(now, baseline, whole=True) if "cause" in each.what]


def test_a_baseline_knows_causes(tmp_path: Path) -> None:
    before, now = report_with("aaaa0001", "aaaa0002"), report_with("aaaa0002", "aaaa0003")
    assert differences(before, now, tmp_path / "b.json") == [
        ("suite rl: new cause aaaa0003: R1", True),
        ("suite rl: cause aaaa0001 is gone: R1", False),
    ]
    assert differences(now, now, tmp_path / "b.json") == []


def test_known_ones_and_what_nobody_looked_for_are_no_difference(tmp_path: Path) -> None:
    known = report_with("aaaa0001", known="aaaa0001")
    assert failure_causes(known, "rl") == {}
    assert differences(report_with("aaaa0002"), known, tmp_path / "b.json") == [
        ("suite rl: cause aaaa0002 is gone: R1", False)
    ]
    undiagnosed = DIAGNOSIS.put(CAUSES.put(report_with("aaaa0001"), ()), None)
    assert failure_causes(undiagnosed, "rl") is None
    assert differences(report_with("aaaa0002"), undiagnosed, tmp_path / "b.json") == []
    assert differences(undiagnosed, report_with("aaaa0002"), tmp_path / "b.json") == []


def test_one_that_the_baseline_has_not_is_called_new() -> None:
    now = report_with("aaaa0002", "aaaa0003")
    found = compare(now, baseline_of(report_with("aaaa0002")), whole=True)
    now = replace(now, gates=GateResult(failed=(), improved=(), differences=found))
    causes = FailingTests.of(now).causes
    assert causes is not None
    titles = [cause.title.partition(":")[0] for cause in causes.causes]
    assert titles == ["cause 1 (aaaa0002)", "cause 2 (aaaa0003, new)"]


def test_a_trend_says_new_since_when_and_gone() -> None:
    reports = [
        report_with("aaaa0001", began="2026-11-20"),
        report_with("aaaa0001", "aaaa0002", began="2026-11-21"),
        report_with("aaaa0002", began="2026-11-22"),
        report_with(began="2026-11-23"),
        report_with("aaaa0001", began="2026-11-24"),
    ]
    entries = [HistoryEntry.of(report, is_whole=True) for report in reports]
    assert compare_causes(entries[:1]) == []
    assert compare_causes(entries[:2]) == ["cause aaaa0001 since 2026-11-20: R1", "new: cause aaaa0002: R1"]
    assert compare_causes(entries[:3]) == ["cause aaaa0002 since 2026-11-21: R1", "gone: cause aaaa0001: R1"]
    assert compare_causes(entries[:4]) == ["gone: cause aaaa0002: R1"]
    assert compare_causes(entries) == ["again: cause aaaa0001: R1"]
    older = [replace(entry, causes=None) for entry in entries[:1]]
    assert compare_causes([*older, entries[1]]) == []


@pytest.mark.slow
def test_sessions_tell_them(surging: pytest.Pytester) -> None:  # noqa: F811
    options = (*SUITE, "--hri-diagnose=9", "--hri-baseline=kept/base.json", "--hri-history=kept/history.jsonl")
    assert surging.runpytest_inprocess(*options, "--hri-update-baseline").ret == 1
    again = surging.runpytest_inprocess(*options)
    assert "new cause" not in again.stdout.str()
    again.stdout.fnmatch_lines(["trend: cause ???????? since 20*: R2", "trend: cause ???????? since 20*: R2"])
    change(surging.path, "conftest.py", 'lamp.set(given["level"])', "lamp.set(0.0)")
    mended = surging.runpytest_inprocess(*options)
    mended.stdout.fnmatch_lines(["trend: gone: cause ????????: R2", "suite surges: cause ???????? is gone: R2"])
