"""A session of a part of the suites keeps the report of whole suites, which it replaces."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.plugin.conftest import SessionRunner
from tests.plugin.project import report

SUITE = ("--hri-suite=rl", "-p", "no:xdist")


def sizes(lamps: pytest.Pytester) -> tuple[int, int | None]:
    """Tests in the report, and in the one that is kept; None where none is."""
    kept = lamps.path / "hri-report" / "whole" / "report.json"
    return report(lamps.path)["reported"], json.loads(kept.read_text("utf-8"))["reported"] if kept.is_file() else None


@pytest.mark.slow
def test_parts_one_after_the_other_leave_it_until_the_next_whole_one(
    lamps: pytest.Pytester, after: SessionRunner
) -> None:
    after(*SUITE)
    every, _ = sizes(lamps)
    name = report(lamps.path)["tests"][0]["id"]
    result = lamps.runpytest_inprocess(*SUITE, "-k", name)
    assert sizes(lamps) == (1, every)
    folder = lamps.path / "hri-report"
    said = [f"full report: {folder / 'whole' / 'index.html'}", f"PASSED  1 of {every} tests: 1 * hri-report/index.html"]
    result.stdout.fnmatch_lines(said)
    assert report(lamps.path)["full_report"] == "whole/index.html"
    assert '<a href="whole/index.html">' in (folder / "index.html").read_text("utf-8")
    lamps.runpytest_inprocess(*SUITE, f"test_lamps.py::test_lamps[{name}]")
    assert sizes(lamps) == (1, every)
    lamps.runpytest_inprocess(*SUITE, "--maxfail=1", "--hri-strict")
    assert sizes(lamps)[1] == every
    lamps.runpytest_inprocess(*SUITE)
    assert sizes(lamps) == (every, None)
    assert "full_report" not in report(lamps.path)


def test_a_part_alone_keeps_nothing(lamps: pytest.Pytester) -> None:
    for _ in range(2):
        result = lamps.runpytest_inprocess(*SUITE, "-k", "hall-polite")
        assert sizes(lamps)[1] is None
        result.stdout.no_fnmatch_line("*kept*")


@pytest.mark.slow
def test_one_that_cannot_be_kept_is_a_failure(
    lamps: pytest.Pytester, after: SessionRunner, monkeypatch: pytest.MonkeyPatch
) -> None:
    after(*SUITE)

    def refused(self: Path, target: Path) -> Path:
        if target.name == "whole":
            raise PermissionError(13, "Permission denied", str(self))
        return rename(self, target)

    rename = Path.rename
    monkeypatch.setattr(Path, "rename", refused)
    result = lamps.runpytest_inprocess(*SUITE, "-k", "hall-polite")
    result.stdout.fnmatch_lines(["FAILED cannot write the report into *: no permission to write there*"])
    assert 0 < sizes(lamps)[0] < 34
