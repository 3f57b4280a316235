"""Merging keeps causes right: in any order, in any steps, and however often a report is given."""

from __future__ import annotations

from msgspec.structs import replace

from pytest_hricdv.extra.diagnosis.merging import associate
from pytest_hricdv.extra.diagnosis.records import CAUSES, DIAGNOSIS, Diagnosis, SuspiciousPlace
from pytest_hricdv.results.codec import canonical
from pytest_hricdv.results.merging import merge
from pytest_hricdv.results.model import Report
from tests.extra.diagnosis.test_causes_of_campaigns import run_of
from tests.report import sample


def part(number: int) -> Report:
    """The report of a part, whose causes are at a place of their own."""
    numbers = range(20 * number, 20 * (number + 1))
    tests = tuple(replace(run_of(test, test % 5 == 0), code=None) for test in numbers)
    report = replace(sample.report(tests=0), tests=tests, known_violations={}, known_when={}, strict=False)
    report = associate(report, is_of_all_runs=False)
    place = SuspiciousPlace(file="controller/states.py", line=number + 1, function="discard", score=1.0, likely=True)
    report = CAUSES.put(report, tuple(replace(cause, locations=(place,)) for cause in CAUSES.of(report)))
    return DIAGNOSIS.put(report, Diagnosis(runs=number + 1, budget=9, end_reason="done"))


def causes(*reports: Report) -> str:
    merged = merge([(str(number), report) for number, report in enumerate(reports)])
    return canonical({"causes": CAUSES.of(merged), "diagnosis": DIAGNOSIS.of(merged)})


def test_the_order_and_a_report_that_is_given_twice_change_nothing() -> None:
    first, second = part(0), part(1)
    merged = merge([("first", first), ("second", second)])
    (cause,) = CAUSES.of(merged)
    assert len(cause.tests) == 8
    assert causes(first, second) == causes(second, first) == causes(first, second, first)
