"""How requirements are suggested."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class SuggestionOptions:
    """How requirements are suggested.

    Args:
        asked: whether they are.
        most: so many are shown at most.
        faults: so many seeded faults rank them, drawn with the seed; 0: none.
        further: so many further tests are run to refute them.
        seconds: no fault is begun later; None: no limit.
        anew: as though there were no requirements yet.
    """

    asked: bool = False
    most: int = 40
    faults: int = 100
    further: int = 20
    seconds: int | None = None
    anew: bool = False
