"""A run of a campaign as a row: what sums are made of, in few bytes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.extra.campaign.plan import RunKey
from pytest_hricdv.results.model import TestResult

LOST = "lost"
"""The outcome of a run that ends the process, or the worker, that runs it, each time."""


@dataclass(frozen=True)
class Row:
    """A run, as far as sums are made of it.

    Args:
        verdicts: in the order of `requirements`; likewise triggers and margins.
        bins: cross product -> the bins that were hit.
        ended: how each interaction ended.
        statements: covered, as a bit set; likewise branches.
    """

    key: RunKey
    outcome: str
    note: str
    sim_s: float
    sha256: str
    verdicts: tuple[str, ...]
    triggers: tuple[int, ...]
    margins: tuple[float | None, ...]
    bins: Mapping[str, list[list[str]]]
    ended: tuple[str, ...]
    statements: int
    branches: int
    worker: int


def requirements(result: TestResult) -> list[str]:
    """The order of a run's verdicts in its row."""
    return sorted(result.requirements)


def columns(result: TestResult) -> tuple[str, ...]:
    """Verdicts, triggers, margins, bins, endings, statements and branches, as the store has them."""
    judged = [result.requirements[name] for name in requirements(result)]
    statements, branches = result.code.bits if result.code else ("0x0", "0x0")
    return (
        " ".join(requirement.verdict for requirement in judged),
        " ".join(str(requirement.triggers) for requirement in judged),
        json.dumps([requirement.margin for requirement in judged]),
        json.dumps({name: sorted(set(hits)) for name, hits in (result.cross or {}).items()}),
        json.dumps(result.outcomes),
        statements,
        branches or "0x0",
    )


def note(result: TestResult) -> str:
    """The first line of why a run failed; empty where it did not."""
    return result.failure.strip().partition("\n")[0] if result.fails else ""


def read_row(fields: tuple[Any, ...]) -> Row:
    """A row of the store. Raises ValueError where it is no such row."""
    test, k, outcome, note, sim_s, sha256, verdicts, triggers, margins, bins, ended, statements, branches, worker = (
        fields
    )
    return Row(
        key=(test, k),
        outcome=outcome,
        note=note,
        sim_s=sim_s,
        sha256=sha256,
        verdicts=tuple(verdicts.split()),
        triggers=tuple(map(int, triggers.split())),
        margins=tuple(json.loads(margins or "[]")),
        bins=json.loads(bins),
        ended=tuple(json.loads(ended)),
        statements=int(statements, 16),
        branches=int(branches, 16),
        worker=worker,
    )
