"""Merges the patch coverage of reports."""

from __future__ import annotations

from collections.abc import Sequence

from pytest_hricdv.extra.patch.records import PATCH, measure
from pytest_hricdv.results.model import Report


def merge(reports: Sequence[Report], merged: Report) -> Report:
    """The merged report with what all tests together reach, where all sessions compared the same code likewise."""
    patches = [PATCH.of(report) for report in reports]
    first = patches[0]
    if first is None or any(patch is None or patch.by_file != first.by_file for patch in patches):
        return merged
    return PATCH.put(merged, measure(merged, first.revision, first.base, first.by_file))
