"""Ranges of a draft's numbers, with notes on their sources, and its times: of a person's waits, and of a run."""

from __future__ import annotations

from pytest_hricdv.extra.draft.code_model import MessageField
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.inputs import number_levels
from pytest_hricdv.extra.draft.project.model import in_order

MAX_PATIENCE_S, PATIENCE = 60.0, 1.1
"""A person waits a little longer for an answer than the robot waits for anything, up to a limit: a run is to end."""

LATE, STAYS = 1.5, 5
"""Greatest factor of a late person's wait; and how many answer times a person stays at the end."""

MIN_LIMIT_S = 900.0
"""Least simulated time that a run gets."""


def number_range(part: MessageField, of_code: str | None) -> tuple[str, str]:
    """The range of a number of a message, and a note on its source or on what is unknown; empty without one.

    Whole numbers of which nothing is known are often counts, and 0 and 1 say little.
    """
    if of_code is not None:
        return of_code, ""
    if part.observed:
        return number_levels(part)[0][2], str(part.location)
    ends = "0, 10" if part.type == "int" else "0.0, 1.0"
    return f"Uniform({ends}" + (f', "{part.unit}")' if part.unit else ")"), "TODO: between which numbers?"


def answer_s(draft: Draft) -> float:
    """How long a person waits for an answer (s)."""
    return max(draft.patience_s, min(draft.late_s[0], MAX_PATIENCE_S) * PATIENCE)


def limit_s(draft: Draft) -> float:
    """Longer than any visit: two rounds, in which all is said late, or all in order, and nothing is answered (s)."""
    late_s, waits_s = LATE * draft.late_s[0], answer_s(draft)
    round_s = max(len(draft.inputs) * (late_s + waits_s), len(in_order(draft)) * (2.0 + waits_s))
    return max(MIN_LIMIT_S, 100.0 * -(-(2 * round_s + STAYS * waits_s) // 100.0))
