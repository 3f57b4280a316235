"""The gates of a run, as they were asked for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from pytest_hricdv.gates.allowance import Allowance
from pytest_hricdv.gates.bound import Bound


@dataclass(frozen=True)
class Gates:
    """What a run is held against.

    Args:
        bounds: of coverage.
        fail_on_nc: fail when no test triggered a requirement, unless `may_be_nc` allows for it.
        may_be_nc: requirements that need not be triggered.
        known: allowances for violations; one that has expired fails the run.
        baseline: what to compare with; None for nothing.
    """

    bounds: tuple[Bound, ...] = ()
    fail_on_nc: bool = False
    may_be_nc: Mapping[str, Allowance] = field(default_factory=dict)
    known: Mapping[str, Allowance] = field(default_factory=dict)
    baseline: Mapping[str, Any] | None = None
