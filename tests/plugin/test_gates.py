"""Gates: coverage, requirements that nobody triggered, allowances that end, illegal bins."""

from __future__ import annotations

import datetime
import re

import pytest

from tests.plugin.conftest import SessionRunner
from tests.plugin.project import (
    change,
    command,
    counted_up_to_313,
    outcomes,
    report,
)

SUITE = ("--hri-suite=by-hand", "-q")
# The suite by hand reaches 40 of 41 statements, 10 of 10 branches, 7 of 9 plans, 3 of 3 requirements, 4 of 8 bins.
BOUNDS = {"statements": 97.5, "branches": 100, "plans": 77.7, "assertions": 100, "cross": 50}
MISSED = {"statements": 98, "branches": 100, "plans": 78, "assertions": 100, "cross": 51}


@counted_up_to_313
def test_the_command_checks_every_gate_of_a_report(finished: SessionRunner) -> None:
    session = finished("--hri-suite=by-hand,rl")
    assert session.result.ret == 0
    folder = str(session.path / "hri-report")
    assert command("gate", folder, *(f"--fail-under={kind}={bound}" for kind, bound in BOUNDS.items())).returncode == 0
    missed = command("gate", folder, "--fail-under=cross=60")
    assert missed.returncode == 1
    assert "FAILED suite by-hand: cross" in missed.stdout
    assert "suite rl: cross" not in missed.stdout


def test_every_missed_kind_is_named_with_what_was_reached(lamps: pytest.Pytester) -> None:
    options = [f"--hri-fail-under={kind}={bound}" for kind, bound in MISSED.items()]
    result = lamps.runpytest_inprocess(*SUITE, *options, "-k", "curt")
    assert result.ret == 1
    result.stdout.fnmatch_lines(
        [
            "FAILED suite by-hand: statements * %, at least 98 % asked for",
            "FAILED suite by-hand: branches * %, at least 100 % asked for",
            "FAILED suite by-hand: plans * %, at least 78 % asked for",
            "FAILED suite by-hand: assertions 66.67 %, at least 100 % asked for",
            "FAILED suite by-hand: cross * %, at least 51 % asked for",
        ]
    )


@pytest.mark.slow
def test_gates_of_the_ini_file_hold_for_whole_suites_only(lamps: pytest.Pytester) -> None:
    change(lamps.path, "pytest.ini", "pythonpath = .", "pythonpath = .\nhri_fail_under =\n    cross=51\n    plans=50")
    whole = lamps.runpytest_inprocess(*SUITE)
    assert whole.ret == 1
    whole.stdout.fnmatch_lines(["FAILED suite by-hand: cross 50.00 %, at least 51 % asked for"])
    whole.stdout.no_fnmatch_line("FAILED suite by-hand: plans*")
    assert lamps.runpytest_inprocess(*SUITE, "-k", "cellar").ret == 0


SILENT = ("--hri-suite=by-hand", "-k", "curt")  # nobody greets, so R3 is never triggered


@pytest.mark.slow
def test_what_need_not_be_triggered_is_allowed_by_name_in_some_suites_or_in_all(lamps: pytest.Pytester) -> None:
    change(lamps.path, "by_hand.toml", '"polite", "bright"', '"curt", "bright"')
    change(lamps.path, "pytest.ini", "pythonpath = .", "pythonpath = .\nhri_allow_nc = R3 in by-hand,rl: nobody greets")
    result = lamps.runpytest_inprocess(*SUITE)
    assert result.ret == 0
    result.stdout.fnmatch_lines(["  R3 never checked, allowed: nobody greets"])
    assert report(lamps.path)["allowed_untriggered"] == {"R3": {"reason": "nobody greets", "suites": ["by-hand", "rl"]}}
    assert "need not be triggered in by-hand, rl: nobody greets." in (lamps.path / "hri-report/index.html").read_text()
    change(lamps.path, "pytest.ini", "by-hand,rl", "rl")
    assert lamps.runpytest_inprocess(*SUITE).ret == 1
    assert lamps.runpytest_inprocess(*SUITE, "--hri-allow-nc=R3 in by-hand").ret == 0


def test_what_need_not_be_checked_is_said_with_a_reason_and_may_end(lamps: pytest.Pytester) -> None:
    change(lamps.path, "by_hand.toml", '"polite", "bright"', '"curt", "bright"')
    ini = "pythonpath = .\nhri_allow_nc =\n    R3 until 2020-02-29: nobody greets yet\n    R1: for a test"
    change(lamps.path, "pytest.ini", "pythonpath = .", ini)
    result = lamps.runpytest_inprocess(*SUITE, "--hri-fail-on=nc")
    assert result.ret == 1
    result.stdout.fnmatch_lines(
        [
            "R1 was checked, so its exemption can go (hri_allow_nc: for a test)",
            "FAILED R3 was not checked, which was accepted until 2020-02-29 (nobody greets yet)",
        ]
    )


def until(lamps: pytest.Pytester, day: datetime.date) -> None:
    """Let the known violation of R2 end with a day."""
    change(lamps.path, "pytest.ini", "R2: the hall", f"R2 until {day}: the hall")


@pytest.mark.slow
def test_a_known_violation_that_has_expired_fails_the_run_and_says_so(lamps: pytest.Pytester) -> None:
    until(lamps, datetime.date(2021, 12, 31))
    result = lamps.runpytest_inprocess(*SUITE)
    assert result.ret == 1
    result.assert_outcomes(passed=3, failed=1)
    told = "FAILED the known violation of R2 (the hall has no dimmer) was accepted until 2021-12-31 and has expired: *"
    result.stdout.fnmatch_lines([told])
    assert report(lamps.path)["known_violations"] == {}
    # Of a part of the tests, only one that violates it is told.
    part = lamps.runpytest_inprocess(*SUITE, "-k", "cellar")
    assert part.ret == 0
    part.stdout.no_fnmatch_line("FAILED *")


def test_a_known_violation_that_is_mended_is_reported(lamps: pytest.Pytester) -> None:
    change(lamps.path, "lamps/guide.py", "wish.cellar and wish.level > GLARE", "wish.level > GLARE")
    result = lamps.runpytest_inprocess(*SUITE)
    assert result.ret == 0
    result.stdout.fnmatch_lines(["R2 is a known violation, but no test violated it (the hall has no dimmer)"])


def test_an_illegal_bin_that_is_hit_fails_its_test(lamps: pytest.Pytester) -> None:
    illegal = 'levels}, illegal={("cellar", "*"): "the cellar is closed"})'
    change(lamps.path, "conftest.py", "levels})", illegal)
    result = lamps.runpytest_inprocess(*SUITE)
    assert result.ret == 1
    result.assert_outcomes(passed=2, xfailed=1, failed=1)
    result.stdout.fnmatch_lines(["*cross product 'light': cellar x 100 must not be hit: the cellar is closed"])
    assert [outcome for name, outcome in outcomes(lamps.path).items() if "cellar" in name] == ["failed"]
    cross = report(lamps.path)["suites"][0]["cross"]
    assert (cross["bins"], cross["illegal"], cross["hit"]) == (8, 4, 3)


@pytest.mark.parametrize(
    ("old", "new", "fault"),
    [
        ("levels})", 'levels}, impossible={("cellar", "*"): "no wire"})', "*: cellar x 100 was hit but is *: no wire"),
        ("[(place, level) for", '[(place, f"{level} %") for', "cross product 'light': ('*', '* %') is not a bin; *"),
        ('cross={"light": [(', 'cross={"lihgt": [(', "cross product: run reported bins of 'lihgt', * are: light"),
    ],
    ids=["impossible", "no bin", "no product"],
)
def test_a_bin_that_cannot_be_fails_its_test_and_keeps_its_verdicts(
    lamps: pytest.Pytester, old: str, new: str, fault: str
) -> None:
    change(lamps.path, "conftest.py", old, new)
    result = lamps.runpytest_inprocess("-vv", *SUITE, "-k", "cellar")
    result.assert_outcomes(failed=1)
    result.stdout.fnmatch_lines([fault, "others:  *Passed*", "run it again:"])
    (test,) = report(lamps.path)["tests"]
    assert (test["outcome"], test["requirements"]["R1"]["verdict"]) == ("failed", "Passed")
    assert (lamps.path / test["replay"]).is_file()


@pytest.mark.slow
def test_what_is_pending_at_the_end_is_said_and_fails_where_it_may_not_be(lamps: pytest.Pytester) -> None:
    """The guide goes on announcing, and nothing answers any more."""
    change(lamps.path, "requirements.toml", "always(on(wish) -> ev", "always(on(switched) -> ev")
    change(lamps.path, "requirements.toml", "(on(switched)))", "(on(switched) & switched.level > 200))")
    change(
        lamps.path,
        "lamps/guide.py",
        "        if wish is None:\n            return\n",
        "        if wish is None:\n            while True:\n                clock.sleep(0.1)\n"
        "                bus.publish(Switched(0.0))\n",
    )
    change(
        lamps.path,
        "conftest.py",
        'code=("lamps",),',
        'code=("lamps",),\n        time=VirtualTime(allowed_endings=("limit",)),',
    )
    said = "  R1 undecided when a run ended, after * triggers"
    lamps.runpytest_inprocess(*SUITE).stdout.fnmatch_lines([said])
    for test in report(lamps.path)["tests"]:
        assert test["sim_s"] == pytest.approx(61.0, abs=0.1)
        assert 8 <= test["requirements"]["R1"]["pending"] <= 11
    assert (
        "pending at the end</strong>: undecided when a run ended" in (lamps.path / "hri-report/index.html").read_text()
    )
    assert command("gate", "hri-report").returncode == 1
    assert "was pending" not in command("gate", "hri-report").stdout
    assert "R1 was pending at the end" in command("gate", "hri-report", "--fail-on-pending").stdout
    result = lamps.runpytest_inprocess(*SUITE, "--hri-fail-on=pending")
    result.stdout.fnmatch_lines(["FAILED R1 was pending at the end: * triggers undecided when their runs ended, for *"])
    assert report(lamps.path)["policy"]["fail_on_pending"]


@pytest.mark.slow
def test_a_session_that_checks_nothing_says_so_first(lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    summary = lamps.path / "job.md"
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", str(summary))
    text = (lamps.path / "requirements.toml").read_text(encoding="utf-8")
    for trigger in ("on(wish)", "lamp_level > 0", "on(greeting)"):
        text = text.replace(f"always({trigger}", "always(lamp_level > 500")
    (lamps.path / "requirements.toml").write_text(text, encoding="utf-8")
    result = lamps.runpytest_inprocess("--hri-suite=bdi-random", "--hri-tests=3", "--color=yes", "-p", "no:xdist")
    assert result.ret == 0
    begin = "\x1b[31m\x1b[1mnothing was checked: no test triggered"
    (start,) = [number for number, line in enumerate(result.outlines) if line.startswith(begin)]
    said = re.sub(r"\x1b\[\d+m", "", " ".join(result.outlines[start : start + 8]))
    assert "(R1, R2, R3), so 3 tests passed vacuously" in said
    assert "which lacked lamp_level > 500" in said
    assert "with --hri-fail-on=nc, this fails the session" in said
    page = (lamps.path / "hri-report" / "index.html").read_text(encoding="utf-8")
    assert '<div class="notice" role="alert"><p>Nothing was checked: ' in page
    assert summary.read_text(encoding="utf-8").startswith(
        "## Human-robot interaction: lamps, nothing checked\n\n**Nothing"
    )
    change(lamps.path, "pytest.ini", "pythonpath = .", "pythonpath = .\nhri_fail_on = nc")
    failed = lamps.runpytest_inprocess("--hri-suite=bdi-random", "--hri-tests=3", "-p", "no:xdist")
    assert failed.ret == 1
    failed.stdout.fnmatch_lines(["nothing was checked: *", "FAILED R1 was not checked: *"])
    failed.stdout.no_fnmatch_line("*with --hri-fail-on*")
