"""Searches of a merged report."""

from __future__ import annotations

import math
from collections.abc import Sequence

from pytest_hricdv.extra.search.records import SEARCH, SearchResult
from pytest_hricdv.results.codec import canonical
from pytest_hricdv.results.model import Report


def merge(reports: Sequence[Report], merged: Report) -> Report:
    """The merged report with, for each requirement, the search that came nearest to violating it."""
    results: dict[str, list[SearchResult]] = {}
    for report in reports:
        for requirement, result in SEARCH.of(report).items():
            results.setdefault(requirement, []).append(result)
    return SEARCH.put(merged, {requirement: min(searches, key=_nearness) for requirement, searches in results.items()})


def _nearness(result: SearchResult) -> tuple[float, str]:
    return (math.inf if result.margin is None else result.margin, canonical(result))
