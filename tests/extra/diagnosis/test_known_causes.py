"""Entries of known violations may name causes: those of another cause are new, and one that is not there is gone."""

from __future__ import annotations

import pytest

from pytest_hricdv.results.gates import ALLOWED_UNTRIGGERED, KNOWN, ExemptionError, parse_exemption
from tests.extra.diagnosis.test_diagnosis_sessions import surging  # noqa: F401 (a fixture)
from tests.plugin.project import report

SUITE = ("--hri-suite=surges.txt", "--hri-allow-nc=R3")


def test_an_entry_names_causes() -> None:
    entry = parse_exemption("R2 of 965b64b5,0dc13159 when on(wish) until 2027-01-31: dim: later [lab]", KNOWN)
    assert (entry.causes, entry.condition, entry.reason) == (("965b64b5", "0dc13159"), "on(wish)", "dim: later [lab]")
    assert entry.text == "of 965b64b5,0dc13159 when on(wish): dim: later [lab]"
    assert parse_exemption("R2: dim", KNOWN).causes == ()


@pytest.mark.parametrize(
    ("line", "form", "message"),
    [
        ("R2 of 965b64b: dim", KNOWN, "'965b64b' is not the id of a cause; expected eight of 0-9 and a-f"),
        ("R2 of surge: dim", KNOWN, "'surge' is not the id of a cause"),
        ("R2 of 965b64b5, 0dc13159: dim", KNOWN, r"expected 'REQUIREMENT: reason' or 'REQUIREMENT \[of CAUSE,...\]"),
        ("R2 of 965b64b5: dim", ALLOWED_UNTRIGGERED, "expected 'REQUIREMENT: reason'"),
    ],
)
def test_what_is_no_id_is_refused(line: str, form: str, message: str) -> None:
    with pytest.raises(ExemptionError, match=message):
        parse_exemption(line, form)


@pytest.mark.slow
def test_a_violation_of_another_cause_fails_and_a_cause_that_is_gone_is_told(
    surging: pytest.Pytester,  # noqa: F811
) -> None:
    surging.runpytest_inprocess(*SUITE, "--hri-strict", "--hri-diagnose=11")
    surge, wish = (cause["id"] for cause in report(surging.path)["causes"])
    both = surging.runpytest_inprocess(*SUITE, f"--hri-known=R2 of {surge},{wish}")
    assert both.ret == 0
    assert "is known of" not in both.stdout.str()
    one = surging.runpytest_inprocess(*SUITE, f"--hri-known=R2 of {surge}")
    assert one.ret == 1
    one.stdout.fnmatch_lines(
        [
            f"FAILED R2 is known of cause {surge}, but 2 tests violate it for cause {wish}, first "
            "surges-2-actions-f3507d88: fix it, or name it in hri_known_violations"
        ]
    )
    three = surging.runpytest_inprocess(*SUITE, f"--hri-known=R2 of {surge},{wish},0123abcd", "-n", "1")
    assert three.ret == 0
    three.stdout.fnmatch_lines(["R2 is known of cause 0123abcd, which is gone: no test fails for it; take it out *"])
    part = surging.runpytest_inprocess(*SUITE, f"--hri-known=R2 of {surge}", "-k", "surges-2-actions-f3507d88")
    assert "is known of" not in part.stdout.str()
