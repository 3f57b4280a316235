"""The suite `closure` through the plugin: what it reaches, what it depends on, and what is wrong input."""

from __future__ import annotations

from collections.abc import Collection

import pytest

from pytest_hricdv.extra.closing import closing
from pytest_hricdv.extra.closing.loop import BatchRunner
from pytest_hricdv.extra.closing.observation import RunObservation
from pytest_hricdv.extra.closing.strategy import Archive
from pytest_hricdv.extra.closing.suite import repeatable_suite
from tests.plugin.project import counted_up_to_313, outcomes, report

SUITE = "--hri-suite=closure"


@pytest.mark.slow
@counted_up_to_313
def test_the_loop_reaches_all_that_the_model_can_reach(lamps: pytest.Pytester) -> None:
    result = lamps.runpytest_inprocess(SUITE, "--hri-close-runs=60")
    assert result.ret == 0
    (suite,) = report(lamps.path)["suites"]
    assert (suite["name"], suite["plans"]["visitor"]["missing"], suite["cross"]["missing"]) == ("closure", [], [])
    assert suite["code"]["statements"]["covered"] == 40  # all but the function that nobody calls
    assert sorted(outcomes(lamps.path).values()) == ["known-violation", *["passed"] * 7]
    result.stdout.fnmatch_lines(
        [
            "hricdv: closing 41 statements, 10 branches, 9 plans, 3 verdicts, 6 conditions, 8 bins, *",
            "hricdv: closing ended (runs) after 60 runs, * open: 1 statement; 8 tests",
        ]
    )


def _with_online(lamps: pytest.Pytester, declared: str) -> None:
    """The visitor can decide during the run; a cross product counts wishes, and beliefs lead to one at most."""
    path = lamps.path / "conftest.py"
    text = path.read_text(encoding="utf-8")
    for old, new in (
        ("Model, Testbench, Uniform", "InteractiveAgent, Model, People, PerceptMapping, Testbench, Uniform"),
        ("        suites=Suites(", f"        people=People(agents=({declared},)),\n        suites=Suites("),
        ('cross={"light": Cross', 'cross={"wishes": CrossProduct({"count": ("0", "1", "2")}), "light": Cross'),
        ('cross={"light": [', 'cross={"wishes": [(str(min(len(levels), 2)),)], "light": ['),
    ):
        assert old in text
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")


def test_a_person_who_cannot_decide_is_an_error_of_the_declaration(lamps: pytest.Pytester) -> None:
    _with_online(lamps, 'InteractiveAgent("visitor", (PerceptMapping("hal", "on(answer)"),))')
    result = lamps.runpytest_inprocess(SUITE)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(
        ["ERROR: --hri-suite=closure: InteractiveAgent: PerceptMapping('hal'): visitor has no belief hal; *: hall*"]
    )


@pytest.mark.slow
def test_a_person_who_decides_during_the_run_reaches_what_no_beliefs_lead_to_and_a_test_does_it_again(
    lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    _with_online(lamps, 'InteractiveAgent("visitor", (PerceptMapping("hall", "on(answer)"),))')
    found: list[tuple[RunObservation, RunObservation]] = []

    def comparing(archive: Archive, strategies: Collection[str], runner: BatchRunner) -> object:
        entries = [entry for entry in archive.entries if entry.strategy in strategies]
        again = dict(runner([entry.test for entry in entries], frozenset()))
        found.extend((again[place], entry.observation) for place, entry in enumerate(entries))
        return repeatable_suite(archive, strategies, runner)

    monkeypatch.setattr(closing, "repeatable_suite", comparing)
    lamps.runpytest_inprocess(SUITE, "--hri-close-runs=64")
    assert len(found) > 5
    for again, first in found:
        assert (again.record_sha256, again.points) == (first.record_sha256, first.points)
    (suite,) = report(lamps.path)["suites"]
    assert "wishes: 2" not in suite["cross"]["missing"], "its tests are not online, and hit it again"
    assert any("-online-" in nodeid for nodeid in outcomes(lamps.path))
