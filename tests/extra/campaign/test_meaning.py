"""What the page says first of a campaign."""

from __future__ import annotations

import pytest

from pytest_hricdv.extra.campaign.records import CampaignRequirement, CampaignResult, CampaignTest, FailedShare
from pytest_hricdv.extra.campaign.view import meaning, short


def _result(outcomes: dict[str, int], failed: dict[str, tuple[int, int]]) -> CampaignResult:
    """A campaign with these outcomes, and of each requirement the runs that failed and that checked it."""
    requirements = {
        name: CampaignRequirement(
            passed=checked - count,
            failed=count,
            nc=0,
            triggers=checked,
            share=FailedShare(failed=count, checked=checked, low=0.0, high=100.0),
            ever=0,
            always=0,
            unsettled=0,
            least=None,
        )
        for name, (count, checked) in failed.items()
    }
    runs = sum(outcomes.values())
    return CampaignResult(
        expected=runs,
        stored=runs,
        concretizations=1,
        sim_s=1.0,
        is_listed=True,
        outcomes=outcomes,
        endings={},
        requirements=requirements,
        tests=(),
        lost=(),
        repeated=0,
        differing=(),
    )


@pytest.mark.parametrize(
    ("outcomes", "failed", "text"),
    [
        ({"passed": 20}, {"R1": (0, 20)}, "None of 20 runs failed."),
        ({"passed": 1}, {}, "None of 1 run failed."),
        ({"passed": 5, "failed": 1}, {"R1": (1, 1), "R2": (0, 6)},
         "1 of 6 runs failed; most often R1, in the one run that checked it."),
        ({"passed": 900, "failed": 300, "lost": 2}, {"R1": (100, 1000), "R2": (250, 1100)},
         "302 of 1,202 runs failed; most often R2, in 250 of the 1,100 runs that checked it."),
        ({"error": 3}, {"R1": (0, 0)}, "3 of 3 runs failed."),
    ],
)  # fmt: skip
def test_it_begins_with_how_many_runs_failed_and_what_failed_most_often(
    outcomes: dict[str, int], failed: dict[str, tuple[int, int]], text: str
) -> None:
    assert meaning(_result(outcomes, failed)) == text


def test_a_run_has_its_number_in_the_test() -> None:
    test = CampaignTest(id="rl-x", suite="rl", runs=2, outcomes={}, failed={}, least={}, keep=())
    assert [short(test, run) for run in ("rl-x", "rl-x-k1")] == ["k0", "k1"]
