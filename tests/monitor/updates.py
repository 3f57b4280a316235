"""Runs as lists of updates, and what is compared of a verdict."""

from __future__ import annotations

from pytest_hricdv.monitor import Verdict
from tests.monitor.vocabulary import Update

MESSAGE: dict[str, float | bool] = {}
NO_P: Update = (0.0, "p", False)


def at(name: str, *times_s: float) -> list[Update]:
    return [(time_s, name, MESSAGE) for time_s in times_s]


def during(name: str, *spans: tuple[float, float]) -> list[Update]:
    """A boolean signal, false from 0 s, true in the half-open spans."""
    updates: list[Update] = [] if spans and spans[0][0] == 0 else [(0.0, name, False)]
    for start_s, end_s in spans:
        updates += [(start_s, name, True), (end_s, name, False)]
    return updates


def in_time(*updates: list[Update]) -> list[Update]:
    return sorted((update for some in updates for update in some), key=lambda update: update[0])


def times(verdict: Verdict) -> list[float]:
    return [violation.time_s for violation in verdict.violations]


def counts(verdict: Verdict) -> tuple[str, int, int, int, int]:
    return verdict.verdict, verdict.triggers, verdict.passes, verdict.failures, verdict.pending
