"""Proposals of known violations: pasted, the same session has exactly those as known."""

from __future__ import annotations

import re

import pytest

from tests.extra.diagnosis.test_diagnosis_sessions import surging as surging
from tests.plugin.project import change, command, outcomes, report

SUITE = "--hri-suite=surges.txt"
WITHOUT_KNOWN = ("hri_known_violations =\n    R2: the hall has no dimmer", "hri_known_violations =")


@pytest.mark.slow
def test_an_entry_that_is_pasted_makes_known_what_fails_for_its_cause_and_nothing_else(
    surging: pytest.Pytester,
) -> None:
    change(surging.path, "pytest.ini", *WITHOUT_KNOWN)
    surging.runpytest_inprocess(SUITE)
    causes = report(surging.path)["causes"]
    done = command("triage", "hri-report")
    assert (done.returncode, done.stderr) == (0, "")
    entries = re.findall(r"^    (R2 of .*)$", done.stdout, re.MULTILINE)
    assert len(entries) == len(causes) == 2
    assert "name all, and join conditions by |" in done.stdout
    for entry, cause in zip(entries, causes, strict=True):
        assert entry.startswith(f"R2 of {cause['id']} when ")
        before = (surging.path / "pytest.ini").read_text(encoding="utf-8")
        (surging.path / "pytest.ini").write_text(before + f"    {entry}\n", encoding="utf-8")
        again = surging.runpytest_inprocess(SUITE)
        assert "is known of" not in again.stdout.str()
        found = outcomes(surging.path)
        assert {name for name, outcome in found.items() if outcome == "known-violation"} == set(cause["tests"])
        others = {test for other in causes if other is not cause for test in other["tests"]}
        assert {name for name, outcome in found.items() if outcome == "failed"} == others
        (surging.path / "pytest.ini").write_text(before, encoding="utf-8")


@pytest.mark.slow
def test_an_entry_with_a_condition_that_is_too_wide_hides_no_other_cause(surging: pytest.Pytester) -> None:
    change(surging.path, "pytest.ini", *WITHOUT_KNOWN)
    surging.runpytest_inprocess(SUITE)
    surge, wish = (cause["id"] for cause in report(surging.path)["causes"])
    entry = next(iter(re.findall(r"^    (R2 of .*)$", command("triage", "hri-report").stdout, re.MULTILINE)))
    wide = entry.replace(re.search(r"when (.*): why", entry)[1], "lamp_level >= 0.0")  # type: ignore[index]
    done = surging.runpytest_inprocess(SUITE, f"--hri-known={wide}", "--hri-allow-nc=R3")
    assert done.ret == 1
    done.stdout.fnmatch_lines([f"FAILED R2 is known of cause {surge}, but 2 tests violate it for cause {wish}, *"])
