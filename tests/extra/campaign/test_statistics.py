"""Sums over the runs of a campaign, against a plain computation from all rows."""

from __future__ import annotations

from collections import Counter
from typing import Literal

import msgspec
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.execution.outcome import TestOutcome
from pytest_hricdv.extra.campaign.database import LOST, Judgement, Row, RowSummary
from pytest_hricdv.extra.campaign.plan import CampaignBasis, CampaignPlan, PlannedTest
from pytest_hricdv.extra.campaign.reporting import Statistics, failure_share
from pytest_hricdv.generate.abstract import AbstractTest

NAMES = ("R1", "R2")
BINS = ("a", "b", "c")
TESTS, SEEDS = 3, 4

outcomes: st.SearchStrategy[TestOutcome | Literal["lost"]] = st.sampled_from(
    ("passed", "failed", "known-violation", LOST)
)
judgements: st.SearchStrategy[Judgement] = st.tuples(
    st.sampled_from(("Passed", "Failed", "NC")), st.integers(0, 2), st.one_of(st.none(), st.integers(-3, 3).map(float))
)
hits = st.lists(st.sampled_from(BINS), unique=True).map(lambda names: {"light": [[name] for name in names]})
summaries = st.builds(
    RowSummary,
    judgements=st.tuples(*(judgements for _ in NAMES)),
    bins=hits,
    statements=st.integers(0, 15).map(hex),
    branches=st.integers(0, 3).map(hex),
)


def verdicts(row: Row) -> list[str]:
    """The verdicts of a run."""
    return [judgement[0] for judgement in row.summary.judgements]


def margins(some: list[Row], place: int) -> list[float]:
    """The margins of a requirement in some runs."""
    return [margin for row in some if (margin := row.summary.judgements[place][2]) is not None]


@st.composite
def rows(draw: st.DrawFn) -> list[Row]:
    """Runs of a campaign, some of which are missing."""
    keys = draw(st.sets(st.tuples(st.integers(0, TESTS - 1), st.integers(0, SEEDS - 1))))
    found = []
    for key in sorted(keys):
        outcome = draw(outcomes)
        lost = outcome == LOST
        found.append(Row(*key, outcome, 1.0, "", 1, RowSummary() if lost else draw(summaries)))
    return found


def planned() -> CampaignPlan:
    """A plan of these tests."""
    tests = [
        AbstractTest(f"s-t{number}-0000000{number}", "s", "t", (), ("go",), seed=number) for number in range(TESTS)
    ]
    listed = tuple(PlannedTest("s", f"test.py::test[{test.id}]", test.to_data()) for test in tests)
    return CampaignPlan(CampaignBasis((), "", listed, {}, {}, msgspec.Raw(b"{}")), SEEDS)


def added(found: list[Row]) -> Statistics:
    """The sums of these rows."""
    statistics = Statistics(NAMES)
    for row in found:
        statistics.add(row)
    return statistics


@given(rows())
def test_sums_are_those_of_all_rows(found: list[Row]) -> None:
    plan, statistics = planned(), added(found)
    done = [row for row in found if row.outcome != LOST]
    for place, (_, each) in enumerate(statistics.of_requirements(plan).items()):
        counts = Counter(verdicts(row)[place] for row in done)
        assert (each.passed, each.failed, each.nc) == (counts["Passed"], counts["Failed"], counts["NC"])
        by_test = [{verdicts(row)[place] for row in done if row.test == test} for test in range(TESTS)]
        assert each.ever == sum("Failed" in found for found in by_test)
        assert each.always == sum(found == {"Failed"} for found in by_test)
        assert each.unsettled == sum(len(found) > 1 for found in by_test)
        least = min(margins(done, place), default=None)
        assert (each.least.margin if each.least else None) == least
    assert [key for key, _ in statistics.lost] == [row.key for row in found if row.outcome == LOST]
    assert dict(statistics.outcomes) == Counter(row.outcome for row in found)


@given(rows())
def test_runs_to_keep_cover_what_all_cover_and_violate_what_all_violate(found: list[Row]) -> None:
    kept = set(added(found).runs_to_keep())
    chosen = [row for row in found if row.key in kept]

    def points(some: list[Row]) -> set[object]:
        hit: set[object] = {bin_[0] for row in some for bin_ in row.summary.bins.get("light", [])}
        hit |= {("statement", bit) for row in some for bit in range(8) if int(row.summary.statements, 16) >> bit & 1}
        hit |= {("branch", bit) for row in some for bit in range(8) if int(row.summary.branches, 16) >> bit & 1}
        return hit | {pair for row in some for pair in zip(NAMES, verdicts(row), strict=False) if pair[1] != "NC"}

    def violations(some: list[Row]) -> set[object]:
        judged = ((row.key[0], pair) for row in some for pair in zip(NAMES, verdicts(row), strict=False))
        return {each for each in judged if each[1][1] == "Failed"}

    assert points(chosen) == points(found)
    assert violations(chosen) == violations(found)
    for place, name in enumerate(NAMES):
        least = added(found).least(name)
        if least is not None:
            assert min(margins([row for row in chosen if row.outcome != LOST], place)) == least[0]


@given(rows())
def test_more_rows_never_lose_a_test(found: list[Row]) -> None:
    plan = planned()
    tests = {test.id: test for test in added(found).of_tests(plan)}
    assert tests.keys() == {plan.tests[row.key[0]].id for row in found}
    assert sum(test.runs for test in tests.values()) == len(found)


def test_a_share_of_nothing_is_wide_open() -> None:
    assert failure_share({"NC": 4}).low == 0.0
    assert failure_share({"NC": 4}).high == 100.0
    half = failure_share({"Failed": 5, "Passed": 5, "NC": 100})
    assert (half.failed, half.checked) == (5, 10)
    assert 23 < half.low < 24
    assert 76 < half.high < 77
