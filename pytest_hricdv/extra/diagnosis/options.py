"""How failures are diagnosed."""

from __future__ import annotations

from dataclasses import dataclass

SHARE = 0.05
"""By default experiments take this share of the session's runs. They run one after the other, and two workers are the
normal way to run a suite: so it is a tenth of the session's time. It depends on runs alone, or the number of workers
would decide what a report says."""

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
        """How many runs experiments may take.

        Args:
            session_runs: of all tests, and of what generated them.
        """
        return max(MIN_RUNS, int(SHARE * session_runs)) if self.runs is None else self.runs
