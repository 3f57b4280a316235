"""`Budget`: the runs and seconds that a search, shrinking, the closing loop or another experiment may take.

They call `spend` before each run, and end at its `BudgetSpentError`.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

#: Why a search ended: it was complete, the budget had no runs or seconds left, or the user pressed Ctrl-C.
Ended = Literal["done", "runs", "seconds", "interrupted"]


class BudgetSpentError(Exception):
    """The budget is spent; `ended` says whether runs or seconds ran out."""

    def __init__(self, ended: Ended) -> None:
        super().__init__(ended)
        self.ended: Ended = ended


@dataclass
class Budget:
    """Counts runs and time. The clock starts when the budget is created.

    Args:
        runs: the maximum number of runs.
        seconds: no run starts after this time (s of wall time); None: no limit.
        clock: returns the wall time (s).
    """

    runs: int
    seconds: float | None = None
    clock: Callable[[], float] = time.perf_counter

    def __post_init__(self) -> None:
        self.used = 0
        self._start_s = self.clock()

    @property
    def age_s(self) -> float:
        """Time since the budget was created (s)."""
        return self.clock() - self._start_s

    def spend(self) -> None:
        """Count one run. Raises BudgetSpentError if none is left."""
        if self.used >= self.runs:
            raise BudgetSpentError("runs")
        if self.seconds is not None and self.age_s >= self.seconds:
            raise BudgetSpentError("seconds")
        self.used += 1
