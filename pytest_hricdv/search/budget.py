"""What a search may cost: so many runs, so many seconds, or until somebody presses Ctrl-C."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

#: Why a search ended: there was nothing left to try, or what it ran out of.
Ended = Literal["done", "runs", "seconds", "interrupted"]


class SpentError(Exception):
    """The budget is spent; `ended` says of what."""

    def __init__(self, ended: Ended) -> None:
        super().__init__(ended)
        self.ended: Ended = ended


@dataclass
class Budget:
    """Counts runs and time. The clock starts when the budget is made.

    Args:
        runs: at most so many.
        seconds: no run is begun after so many (s of wall time); None: no limit.
        clock: of wall time (s).
    """

    runs: int
    seconds: float | None = None
    clock: Callable[[], float] = time.perf_counter

    def __post_init__(self) -> None:
        self.used = 0
        self._began_s = self.clock()

    @property
    def elapsed_s(self) -> float:
        """Since it was made (s)."""
        return self.clock() - self._began_s

    def spend(self) -> None:
        """Take one run off. Raises SpentError where there is none left."""
        if self.used >= self.runs:
            raise SpentError("runs")
        if self.seconds is not None and self.elapsed_s >= self.seconds:
            raise SpentError("seconds")
        self.used += 1
