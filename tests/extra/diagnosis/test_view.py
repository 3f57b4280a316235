"""What is said below the causes: on what they rest."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from pytest_hricdv.extra.diagnosis.records import (
    CAUSES,
    DIAGNOSIS,
    Cause,
    Diagnosis,
    DiagnosisEnd,
    SuspiciousPlace,
)
from pytest_hricdv.extra.diagnosis.view import VIEW
from tests.report import sample
from tests.report.test_html import render

REPORT = sample.report(tests=3)
CAUSE = Cause(id="a", requirements=("R1",), tests=(REPORT.tests[0].id,))


@pytest.mark.parametrize(
    ("ended", "said"),
    [("done", ""), ("runs", "; the budget is used up"), ("interrupted", "; interrupted")],
)
def test_it_says_why_experiments_ended(ended: DiagnosisEnd, said: str) -> None:
    report = DIAGNOSIS.put(CAUSES.put(REPORT, (CAUSE,)), Diagnosis(runs=2, budget=2, end_reason=ended))
    shown = VIEW.causes(report, 100)
    assert shown is not None
    assert shown.remark == f"causes: by association over all tests, and 2 runs of experiments{said}"


def test_only_likely_locations_are_shown() -> None:
    locations = tuple(
        SuspiciousPlace(file="a.py", line=line, function="move", score=0.9, likely=line == 7) for line in (3, 7)
    )
    report = CAUSES.put(REPORT, (replace(CAUSE, locations=locations),))
    shown = VIEW.causes(report, 100)
    assert shown is not None
    assert shown.causes[0].place == ("a.py", 7)
    texts = [*(line.text for line in shown.causes[0].lines), render(report)]
    assert any("a.py:7" in text for text in texts)
    assert not any("a.py:3" in text for text in texts)


def test_a_location_says_which_experiment_has_shown_it() -> None:
    place = SuspiciousPlace(
        file="a.py", line=3, function="move", score=0.7, likely=True, experiment="passes without this call", text="go()"
    )
    report = CAUSES.put(REPORT, (replace(CAUSE, locations=(place,)),))
    shown = VIEW.causes(report, 100)
    assert shown is not None
    assert "  where  a.py:3 in move (passes without this call): go()" in [line.text for line in shown.causes[0].lines]
    assert "passes without this call" in render(report)
