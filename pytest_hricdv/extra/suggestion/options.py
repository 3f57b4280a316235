"""The options of suggestions: how many requirements, from how many seeded bugs and further tests."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SuggestionOptions:
    """How requirements are suggested.

    Args:
        asked: whether requirements are suggested (`hricdv suggest`).
        most: maximum number of suggestions.
        faults: number of seeded bugs that rank them, drawn with the seed.
        further: number of tests with other parameters that they hold in, too.
        seconds: no bug is started later; None: no limit.
        anew: whether to ignore existing requirements.
    """

    asked: bool = False
    most: int = 10
    faults: int = 100
    further: int = 20
    seconds: int | None = None
    anew: bool = False
