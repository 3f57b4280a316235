"""Campaigns have causes over all seeds, and say how probable each is."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from msgspec import convert
from msgspec.structs import replace

from pytest_hricdv.extra.diagnosis.locations import locate
from pytest_hricdv.extra.diagnosis.merging import associate
from pytest_hricdv.extra.diagnosis.records import CAUSES, DIAGNOSIS
from pytest_hricdv.extra.diagnosis.spectrum import Suspect
from pytest_hricdv.extra.diagnosis.subject import Subject
from pytest_hricdv.report.failing_tests import FailingTests
from pytest_hricdv.results.model import Report, TestResult
from tests import json_schema
from tests.extra.campaign.conftest import RUN, command, lamps  # noqa: F401 (a fixture)
from tests.plugin import project
from tests.report import sample, sample_tests


def run_of(number: int, failing: bool) -> TestResult:
    """A run of a campaign; of every tenth R1 fails."""
    made = sample_tests.test(random.Random(number), "rl")
    made["requirements"] = sample_tests.requirement_results(*(["R1"] if failing else []))
    made |= {"outcome": "failed" if failing else "passed"}
    return convert(made, TestResult)


def campaign(runs: int, every: int) -> Report:
    tests = tuple(run_of(number, number % every == 0) for number in range(runs))
    return replace(sample.report(tests=0), tests=tests, known_violations={}, known_when={}, strict=False)


def test_each_cause_has_its_share_of_runs_with_an_interval() -> None:
    report = associate(campaign(200, 10), is_of_all_runs=True)
    (cause,) = CAUSES.of(report)
    assert cause.probability is not None
    assert (cause.probability.failing, cause.probability.runs) == (20, 200)
    assert cause.probability.low < 10 < cause.probability.high
    assert DIAGNOSIS.of(report) is None
    title = f"cause 1 ({cause.id}): R1 in 20 of 200 runs, 10.00 % (6.57 to 14.94)"
    assert next(FailingTests.of(report).lines(None)).text.startswith(title)


@pytest.mark.parametrize(
    ("second", "is_compared", "is_switched", "is_likely"),
    [
        (0.70, True, False, True),
        (0.80, True, False, False),  # it might as well be the second one
        (0.70, False, False, False),  # no test has passed
        (0.70, False, True, True),
    ],
)
def test_a_location_is_likely_where_it_leads_and_runs_support_it(
    second: float, is_compared: bool, is_switched: bool, is_likely: bool
) -> None:
    subject = Subject.of(campaign(20, 2))
    file = subject.report.code_under_test.map[0].file
    ranked = [Suspect(file, 1, 0.9, 0), Suspect(file, 2, second, 0)]
    places = locate(subject, ranked, [(file, 1)] if is_switched else [], is_compared=is_compared)
    assert [place.likely for place in places] == [is_likely, False]


def test_no_location_is_likely_where_no_test_has_passed() -> None:
    (cause,) = CAUSES.of(associate(campaign(5, 1), is_of_all_runs=True))
    assert cause.locations[0].score == 1.0
    assert {location.likely for location in cause.locations} == {False}


@pytest.mark.slow
def test_a_campaign_s_report_has_them(lamps: Path) -> None:  # noqa: F811
    project.change(lamps, "requirements.toml", "lamp_level <= 80", "lamp_level <= 5")
    assert command(lamps, *RUN, "--", "--hri-strict").returncode == 1
    reported = command(lamps, "report", "--state=a.db")
    assert reported.returncode == 1
    lines = reported.stdout.splitlines()
    start = next(number for number, line in enumerate(lines) if " fail for " in line)
    assert "of 20 runs, " in lines[start + 1]
    written = project.report(lamps)
    json_schema.REPORT.validate(written)
    assert written["causes"][0]["probability"]["runs"] == 20
