"""Records of a campaign in a report: `CampaignResult` has the sums over all runs, by requirement and by test.

`reporting` makes them; `view` shows them.
"""

from __future__ import annotations

from collections.abc import Mapping

from pytest_hricdv._base.record import Count, Names, NotNegative, Number, Percent, PlainRecord
from pytest_hricdv.results.section import Section


class FailedShare(PlainRecord, frozen=True, kw_only=True):
    """The share of runs that violated a requirement, of those that checked it, with its 95 % interval (per cent).

    The interval is Wilson's (1927); of runs that checked nothing, all of it is open.
    """

    failed: Count
    checked: Count
    low: Percent
    high: Percent


class LeastMargin(PlainRecord, frozen=True, kw_only=True):
    """The least margin of all runs, and the first run that has it; negative where the requirement was violated."""

    margin: Number
    run: str


class CampaignRequirement(PlainRecord, frozen=True, kw_only=True):
    """A requirement over all runs.

    Args:
        passed: runs, as `failed` and `nc` (not checked).
        triggers: checks in all runs.
        ever: abstract tests that violated it with some seed.
        always: abstract tests that violated it with each seed.
        unsettled: abstract tests whose verdict depends on the seed.
        least: the smallest margin; None if there is none.
    """

    passed: Count
    failed: Count
    nc: Count
    triggers: Count
    share: FailedShare
    ever: Count
    always: Count
    unsettled: Count
    least: LeastMargin | None


class CampaignTest(PlainRecord, frozen=True, kw_only=True):
    """An abstract test over all of its seeds.

    Args:
        id: the id of the abstract test; its runs have it, and a number from -k1 on.
        outcomes: outcome -> runs.
        failed: requirement -> share of its runs that violated it; without those that none violated.
        least: requirement -> its least margin.
        keep: ids of its runs that are worth keeping: they add coverage to the runs before, are the first to violate a
            requirement in this test, or have the least margin of all.
    """

    id: str
    suite: str
    runs: Count
    outcomes: Mapping[str, Count]
    failed: Mapping[str, FailedShare]
    least: Mapping[str, LeastMargin]
    keep: Names


class LostRun(PlainRecord, frozen=True, kw_only=True):
    """A run that ended its process, or its worker, each time; why."""

    id: str
    reason: str


class DifferingRun(PlainRecord, frozen=True, kw_only=True):
    """A run that gave another record elsewhere: where the two part, and in which versions the workers differ."""

    id: str
    parting: str
    versions: str


class CampaignResult(PlainRecord, frozen=True, kw_only=True):
    """All runs of a campaign.

    Args:
        expected: runs; `stored` have an outcome.
        sim_s: simulated by all (s).
        is_listed: whether the report lists all runs as tests, not only those to keep.
        outcomes: outcome -> runs.
        endings: end of an interaction -> count.
        requirements: requirement -> over all runs.
        repeated: runs that were done again, on another worker where there is one.
        differing: number of repeated runs that gave another record.
    """

    expected: Count
    stored: Count
    concretizations: Count
    sim_s: NotNegative
    is_listed: bool
    outcomes: Mapping[str, Count]
    endings: Mapping[str, Count]
    requirements: Mapping[str, CampaignRequirement]
    tests: tuple[CampaignTest, ...]
    lost: tuple[LostRun, ...]
    repeated: Count
    differing: tuple[DifferingRun, ...]

    @property
    def not_run(self) -> int:
        """Runs without an outcome."""
        return self.expected - self.stored


CAMPAIGN: Section[CampaignResult | None] = Section("campaign", CampaignResult | None, None)
"""The result of a campaign; a merged report has none."""

SECTIONS = (CAMPAIGN,)
