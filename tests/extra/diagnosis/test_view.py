"""What is said below the causes: on what they rest."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from pytest_hricdv.extra.diagnosis.records import (
    CAUSES,
    DIAGNOSIS,
    Cause,
    Decision,
    Diagnosis,
    DiagnosisEnd,
    ShownEvent,
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


def test_a_decision_on_a_test_that_the_report_has_not_is_shown_without_links() -> None:
    event = ShownEvent(time_s=1.5, text="hand_closing on")
    decision = Decision(words="without it", kind="action", test="gone", runs=3, failing=(event,), passing=(event,))
    page = render(CAUSES.put(REPORT, (replace(CAUSE, minimal_pair=decision),)))
    assert "<th>gone fails</th>" in page
    assert "1.500 s" in page


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


def test_without_a_likely_location_it_says_where_the_code_was() -> None:
    unlikely = SuspiciousPlace(file="a.py", line=3, function="move", score=0.2, likely=False)
    cause = replace(CAUSE, locations=(unlikely,), stood=("a.py:9 in move", "b.py:4 in watch"))
    report = CAUSES.put(REPORT, (cause,))
    shown = VIEW.causes(report, 100)
    assert shown is not None
    assert "  where  a.py:9 in move; b.py:4 in watch, where the code was then" in [
        line.text for line in shown.causes[0].lines
    ]
    assert 'the code was at <span class="mono">a.py:9 in move; b.py:4 in watch</span>' in render(report)


def test_a_location_says_which_experiment_has_shown_it() -> None:
    place = SuspiciousPlace(
        file="a.py", line=3, function="move", score=0.7, likely=True, experiment="passes without this call", text="go()"
    )
    report = CAUSES.put(REPORT, (replace(CAUSE, locations=(place,)),))
    shown = VIEW.causes(report, 100)
    assert shown is not None
    assert "  where  a.py:3 in move (passes without this call): go()" in [line.text for line in shown.causes[0].lines]
    assert "passes without this call" in render(report)
