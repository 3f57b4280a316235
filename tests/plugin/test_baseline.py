"""The baseline: what is worse than it fails the session, what is better is said, and it keeps what did not run."""

from __future__ import annotations

import pytest

from tests.plugin.conftest import SessionRunner
from tests.plugin.project import (
    change,
)

SUITE = ("--hri-suite=by-hand", "-q")

BASE = "--hri-baseline=base.json"


@pytest.fixture
def kept(after: SessionRunner) -> None:
    """The project has a baseline."""
    after(*SUITE, BASE, "--hri-update-baseline")


@pytest.mark.slow
@pytest.mark.usefixtures("kept")
def test_new_failures_and_losses_fail_though_known_ones_do_not(lamps: pytest.Pytester) -> None:
    # In the cellar it glares now, too: a violation of a requirement whose violation is known. And nobody is dim.
    change(lamps.path, "lamps/guide.py", "        return GLARE\n", "        return 100.0\n")
    change(lamps.path, "by_hand.toml", '"curt", "d*"', '"curt", "dark"')
    result = lamps.runpytest_inprocess(*SUITE, BASE)
    assert result.ret == 1
    result.assert_outcomes(failed=0, xfailed=2, passed=1)
    result.stdout.fnmatch_lines(
        [
            "FAILED suite by-hand: R2 is newly violated by by-hand-cellar-polite-*: grown from 1 to 2 tests",
            "FAILED suite by-hand: statements * %; * % in the baseline",
            "FAILED suite by-hand: lost plans of visitor: v6",
            "FAILED suite by-hand: lost bins of light: hall x 10",
        ]
    )


@pytest.mark.slow
def test_lost_triggers_fail_and_what_is_better_is_reported(lamps: pytest.Pytester) -> None:
    change(lamps.path, "by_hand.toml", '"curt", "d*"', '"curt", "dark"')
    assert lamps.runpytest_inprocess(*SUITE, BASE, "--hri-update-baseline").ret == 0
    change(lamps.path, "by_hand.toml", '"polite", "bright"', '"curt", "dim"')
    result = lamps.runpytest_inprocess(*SUITE, BASE)
    assert result.ret == 1
    result.stdout.fnmatch_lines(
        [
            "suite by-hand: R2 is no longer violated by by-hand-hall-polite-*",
            "suite by-hand: gained plans of visitor: v6",
            "FAILED suite by-hand: R3 is no longer triggered; 2 times in the baseline",
        ]
    )


@pytest.mark.slow
@pytest.mark.usefixtures("kept")
def test_a_part_of_the_tests_is_compared_for_failures_only_and_is_no_baseline(lamps: pytest.Pytester) -> None:
    kept = (lamps.path / "base.json").read_bytes()
    assert lamps.runpytest_inprocess(*SUITE, BASE, "-k", "cellar").ret == 0
    result = lamps.runpytest_inprocess(*SUITE, BASE, "--hri-update-baseline", "-k", "cellar")
    assert result.ret == 1
    result.stdout.fnmatch_lines(["FAILED *base.json was not updated: only 1 of its tests ran; run the whole suites"])
    change(lamps.path, "lamps/guide.py", "        return GLARE\n", "        return 100.0\n")
    result = lamps.runpytest_inprocess(*SUITE, BASE, "-k", "cellar")
    assert result.ret == 1
    result.stdout.fnmatch_lines(["FAILED suite by-hand: R2 is newly violated by by-hand-cellar-polite-*"])
    assert (lamps.path / "base.json").read_bytes() == kept


@pytest.mark.slow
@pytest.mark.parametrize(
    ("spoil", "told"),
    [
        (lambda text: text[:100], "base.json:*: not JSON, perhaps cut off *"),
        (lambda text: text.replace("baseline/2", "baseline/7"), "base.json: Invalid enum value 'hricdv-baseline/7'*"),
        (lambda text: text.replace('"lamps"', '"chairs"'), "base.json: of the testbench 'chairs'; expected 'lamps'"),
        (lambda text: text.replace('"triggers"', '"trigger"'), "base.json: *missing required field `triggers` - at *"),
    ],
)
@pytest.mark.usefixtures("kept")
def test_a_spoilt_baseline_is_refused_before_anything_runs(lamps: pytest.Pytester, spoil: object, told: str) -> None:
    path = lamps.path / "base.json"
    path.write_text(spoil(path.read_text(encoding="utf-8")), encoding="utf-8")  # type: ignore[operator]
    result = lamps.runpytest_inprocess(*SUITE, BASE)
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([f"ERROR: --hri-baseline: *{told}"])
