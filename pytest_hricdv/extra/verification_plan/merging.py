"""The verification plan of a merged report."""

from __future__ import annotations

from collections.abc import Sequence

from pytest_hricdv.extra.verification_plan.evaluation import evaluated
from pytest_hricdv.extra.verification_plan.records import PLAN
from pytest_hricdv.results.model import Report


def merge(reports: Sequence[Report], merged: Report) -> Report:
    """The merged report with how far the plan is, where all reports have the same one."""
    plans = [[part.wanted() for part in PLAN.of(report)] for report in reports]
    return PLAN.put(merged, evaluated(plans[0], merged)) if all(plan == plans[0] for plan in plans) else merged
