"""Rows: a run of a campaign in few bytes, from which sums are computed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal

import msgspec
from msgspec import Meta

from pytest_hricdv._base.record import Count, NotNegative, Number
from pytest_hricdv.execution.judge import TestOutcome
from pytest_hricdv.extra.campaign.plan import RunKey
from pytest_hricdv.results.model import TestResult

LOST: Final = "lost"
"""The outcome of a run that ends its process, or its worker, each time."""

Bits = Annotated[str, Meta(pattern=r"^0x[0-9a-f]+\Z")]

Judgement = tuple[Literal["Passed", "Failed", "NC"], Count, Number | None]
"""Verdict of a requirement, how often it was triggered, and its margin."""


class RowSummary(msgspec.Struct, frozen=True):
    """A run's contribution to sums; for a lost run only the reason.

    Args:
        note: the first line of why it failed or was lost.
        judgements: one for each requirement, sorted by requirement.
        bins: cross product -> the bins that were hit.
        endings: how each interaction ended.
        statements: covered, as a bit set; likewise branches.
    """

    note: str = ""
    judgements: tuple[Judgement, ...] = ()
    bins: Mapping[str, list[list[str]]] = {}
    endings: tuple[str, ...] = ()
    statements: Bits = "0x0"
    branches: Bits = "0x0"

    @classmethod
    def of_result(cls, result: TestResult) -> RowSummary:
        """Summarize the result of a run."""
        judged = [result.requirements[name] for name in sorted(result.requirements)]
        statements, branches = result.code.bits if result.code else ("0x0", "0x0")
        return cls(
            note=result.failure.strip().partition("\n")[0] if result.fails else "",
            judgements=tuple((each.verdict, each.triggers, each.margin) for each in judged),
            bins={name: [list(hit) for hit in sorted(set(hits))] for name, hits in (result.cross or {}).items()},
            endings=tuple(result.outcomes),
            statements=statements,
            branches=branches or "0x0",
        )


class Row(msgspec.Struct, frozen=True, array_like=True):
    """A row of the store: columns that queries use, and the summary."""

    test: Count
    k: Count
    outcome: TestOutcome | Literal["lost"]
    sim_s: NotNegative
    sha256: str
    worker: Count
    summary: RowSummary

    @property
    def key(self) -> RunKey:
        """The run that it is of."""
        return self.test, self.k


def read_row(cells: tuple[Any, ...]) -> Row:
    """Check the cells of a row: columns of SQLite take values of any type.

    Raises:
        msgspec.MsgspecError: they are no such row.
    """
    *columns, summary = cells
    return msgspec.convert((*columns, msgspec.json.decode(msgspec.convert(summary, str))), Row)
