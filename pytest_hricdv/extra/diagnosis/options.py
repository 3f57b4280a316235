"""The options of the diagnosis: how many runs its experiments may take."""

from __future__ import annotations

from dataclasses import dataclass

SHARE = 0.05
"""Default share of the session's runs for experiments. They run one after the other, and a suite usually has two
workers, so they take a tenth of the session's time. It depends on runs alone; otherwise the number of workers would
change the report."""

MIN_RUNS = 48
"""The budget of a small session. Half of it shrinks a test of four actions and tries all changes of one thing; the
other half reverses some ten decisions in two tests."""


@dataclass(frozen=True)
class DiagnosisOptions:
    """How failures are diagnosed.

    Args:
        runs: the maximum number of experiments; 0 switches diagnosis off. None: a twentieth of the session's runs, at
            least `MIN_RUNS`.
    """

    runs: int | None = None

    def budget(self, session_runs: int) -> int:
        """The number of runs that experiments may take, given that of all tests and of what generated them."""
        return max(MIN_RUNS, int(SHARE * session_runs)) if self.runs is None else self.runs
