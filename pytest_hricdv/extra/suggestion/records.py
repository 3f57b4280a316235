"""Records of suggested requirements in `report.json`: `Suggestion` and `SuggestionResult`.

`suggest` makes them; `feature` shows them in the terminal and on the page of the report.
"""

from __future__ import annotations

from typing import Literal

from pytest_hricdv._base.record import Count, NotNegative, Number, PlainRecord
from pytest_hricdv.results.section import Section

SuggestionEnd = Literal["done", "seconds", "interrupted"]


class Suggestion(PlainRecord, frozen=True, kw_only=True):
    """A requirement that all runs satisfied, and that is not accepted yet.

    Args:
        id: a name that no requirement has.
        formula: the formula of the language of requirements.
        form: response, precedence, bound or absence.
        triggers: how often it applied, in all runs of the original code.
        decisive: number of these runs in which it passed; in the others it was not checked.
        margin: the least one, in the unit of its comparison; None where nothing is compared.
        observed: the extreme that its bound was made of; empty for none.
        faults: number of seeded bugs that it notices.
        new: how many of these no requirement notices.
        added: how many of those no suggestion above it notices, either.
    """

    id: str
    title: str
    formula: str
    form: str
    triggers: Count
    decisive: Count
    margin: Number | None
    observed: str
    faults: Count
    new: Count
    added: Count


class SuggestionResult(PlainRecord, frozen=True, kw_only=True):
    """The result of suggesting requirements.

    Args:
        suggestions: those that were not redundant, in the order of what they bring; at most as many as were asked for.
        more: how many further ones there were.
        runs: number of runs of the session's tests, in the original code, that they were learned from.
        validation_runs: the same, of tests with other parameters.
        candidates: number of candidates that these runs satisfied.
        refuted: candidates that failed where a run continued until they were decided.
        faults: number of seeded bugs that changed a record.
        noticed: those of them that requirements notice, or that end a run by an exception.
        unreached: number of seeded bugs whose statement no test executes.
        ignores_existing: whether they were made as if there were no requirements.
        seed: the seed with which tests and bugs were drawn.
        notes: what is to be known, a sentence each.
    """

    suggestions: tuple[Suggestion, ...]
    more: Count
    runs: Count
    validation_runs: Count
    candidates: Count
    refuted: Count
    faults: Count
    noticed: Count
    unreached: Count
    ignores_existing: bool
    seed: int
    wall_s: NotNegative
    end_reason: SuggestionEnd
    notes: tuple[str, ...] = ()


SUGGESTIONS: Section[SuggestionResult | None] = Section("suggestions", SuggestionResult | None, None)
"""The suggestions of a session that was asked for them; a merged report has none."""

SECTIONS = (SUGGESTIONS,)
