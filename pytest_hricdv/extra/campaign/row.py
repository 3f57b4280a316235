"""A run of a campaign as a row: what sums are made of, in few bytes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from pytest_hricdv._base.record import Count, NotNegative
from pytest_hricdv.execution.outcome import TestOutcome
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


Bits = Annotated[str, Meta(pattern=r"^0x[0-9a-f]+\Z")]


class _Cells(msgspec.Struct, array_like=True):
    """A row as SQLite has it, whose columns take values of any type."""

    test: Count
    k: Count
    outcome: TestOutcome | Literal["lost"]
    note: str
    sim_s: NotNegative
    sha256: str
    verdicts: Annotated[str, Meta(pattern=r"^((Passed|Failed|NC)( |\Z))*\Z")]
    triggers: Annotated[str, Meta(pattern=r"^(\d{1,18}( |\Z))*\Z")]
    margins: str
    bins: str
    ended: str
    statements: Bits
    branches: Bits
    worker: Count


def read_row(fields: tuple[Any, ...]) -> Row:
    """A row of the store. Raises msgspec.ValidationError or ValueError where it is no such row."""
    cells = msgspec.convert(fields, _Cells)
    row = Row(
        key=(cells.test, cells.k),
        outcome=cells.outcome,
        note=cells.note,
        sim_s=cells.sim_s,
        sha256=cells.sha256,
        verdicts=tuple(cells.verdicts.split()),
        triggers=tuple(map(int, cells.triggers.split())),
        margins=msgspec.convert(json.loads(cells.margins or "[]"), tuple[int | float | None, ...]),
        bins=msgspec.convert(json.loads(cells.bins), dict[str, list[list[str]]]),
        ended=msgspec.convert(json.loads(cells.ended), tuple[str, ...]),
        statements=int(cells.statements, 16),
        branches=int(cells.branches, 16),
        worker=cells.worker,
    )
    if not len(row.verdicts) == len(row.triggers) == len(row.margins):
        raise ValueError(f"run {row.key}: expected a verdict, a count and a margin for each requirement")
    return row
