"""What is said below the causes: on what they rest, and what further runs would bring."""

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
)
from pytest_hricdv.extra.diagnosis.view import VIEW
from tests.report import sample
from tests.report.test_html import render

REPORT = sample.report(tests=3)
OPEN, MENDED, KNOWN = (
    Cause(id=name, requirements=("R1",), tests=(REPORT.tests[0].id,), hints=hints, is_known=is_known)
    for name, hints, is_known in (("a", (), False), ("b", ("without `x`",), False), ("c", (), True))
)


@pytest.mark.parametrize(
    ("causes", "budget", "ended", "said"),
    [
        ((OPEN,), 2, "done", "2 runs of experiments; --hri-diagnose=40 also tries repairs of the code"),
        (
            (OPEN, OPEN, KNOWN),
            2,
            "runs",
            "2 runs of experiments; the budget is used up; --hri-diagnose=80 also tries repairs of the code",
        ),
        ((OPEN,), 20, "done", "2 runs of experiments"),
        (
            (OPEN, MENDED),
            20,
            "runs",
            "2 runs of experiments; the budget is used up; --hri-diagnose=40 allows more",
        ),
        ((KNOWN,), 2, "done", "2 runs of experiments"),
        ((MENDED,), 2, "runs", "2 runs of experiments; the budget is used up"),
        ((OPEN,), 2, "interrupted", "2 runs of experiments; interrupted"),
    ],
)
def test_it_says_how_many_runs_would_bring_more(
    causes: tuple[Cause, ...], budget: int, ended: DiagnosisEnd, said: str
) -> None:
    report = DIAGNOSIS.put(CAUSES.put(REPORT, causes), Diagnosis(runs=2, budget=budget, ended=ended))
    shown = VIEW.causes(report, 100)
    assert shown is not None
    assert shown.remark == f"causes: by association over all tests, and {said}"


def test_a_decision_on_a_test_that_the_report_has_not_is_shown_without_links() -> None:
    event = ShownEvent(time_s=1.5, text="hand_closing on")
    decision = Decision(words="without it", kind="action", test="gone", runs=3, failing=(event,), passing=(event,))
    page = render(CAUSES.put(REPORT, (replace(OPEN, decision=decision),)))
    assert "<th>gone fails</th>" in page
    assert "1.500 s" in page
