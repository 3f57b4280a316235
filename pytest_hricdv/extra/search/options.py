"""How failing tests are shrunk, and violations searched for."""

from __future__ import annotations

from dataclasses import dataclass

BUDGET = 60
"""Chosen: a test of the table has at most some 30 actions, and dropping each of them once is 30 runs."""


@dataclass(frozen=True)
class SearchOptions:
    """How failing tests are shrunk and violations searched for.

    Args:
        shrink: whether tests are shrunk.
        shrink_runs: at most so many runs for each of them.
        shrink_seconds: at most so long (s) for each of them.
        search: at most so many runs for each requirement; 0: there is no search.
    """

    shrink: bool = False
    shrink_runs: int = BUDGET
    shrink_seconds: int = BUDGET
    search: int = 0
