"""The closing loop of a merged report."""

from __future__ import annotations

from collections.abc import Sequence

from pytest_hricdv.extra.closing.records import CLOSING
from pytest_hricdv.results.model import Report


def merge(reports: Sequence[Report], merged: Report) -> Report:
    """The merged report with the loop, where all sessions had the same one."""
    first, *others = (CLOSING.of(report) for report in reports)
    return CLOSING.put(merged, first) if all(other == first for other in others) else merged
