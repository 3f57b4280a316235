"""How failures are diagnosed."""

from __future__ import annotations

from dataclasses import dataclass

SHARE = 0.05
"""By default experiments take this share of the session's runs. They run one after the other, and two workers are the
normal way to run a suite: so it is a tenth of the session's time. It depends on runs alone, or the number of workers
would decide what a report says."""


LEAST_FOR_REPAIRS = 12
"""With fewer runs, hardly any repair would be tried. Chosen."""

ENOUGH_FOR_REPAIRS = 40
"""So many runs for a cause, half of them for repairs, are proposed where none was tried. Chosen: the tutorial's bug is
mended by one of the first ten repairs, and this one then stands seven more runs."""


@dataclass(frozen=True)
class DiagnosisOptions:
    """How failures are diagnosed.

    Args:
        runs: at most so many runs of experiments; None: one in twenty of the session's runs; 0: no diagnosis.
    """

    runs: int | None = None

    def budget(self, session_runs: int) -> int:
        """How many runs experiments may take.

        Args:
            session_runs: of all tests, and of what generated them.
        """
        return max(2, int(SHARE * session_runs)) if self.runs is None else self.runs

    def for_repairs(self, budget: int) -> int:
        """How many of these runs are kept for repairs of the code: none of a small budget, which shows little of them.

        Args:
            budget: see above.
        """
        return budget // 2 if budget >= LEAST_FOR_REPAIRS else 0
