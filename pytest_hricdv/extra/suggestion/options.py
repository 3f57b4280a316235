"""The options of suggestions: how many requirements, from how many seeded bugs and further tests."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SuggestionOptions:
    """How requirements are suggested.

    Args:
        asked: whether they are.
        most: at most this many are shown.
        faults: number of seeded bugs that rank them, drawn with the seed.
        further: number of tests with other parameters that they hold in, too.
        seconds: no bug is started later; None: no limit.
        anew: as if there were no requirements.
    """

    asked: bool = False
    most: int = 10
    faults: int = 100
    further: int = 20
    seconds: int | None = None
    anew: bool = False
