"""All that may be suggested of runs: candidates of each form, none twice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from pytest_hricdv.extra.suggestion.absences import absences
from pytest_hricdv.extra.suggestion.bounds import bounds
from pytest_hricdv.extra.suggestion.candidate import LEAST_SUPPORT, Candidate
from pytest_hricdv.extra.suggestion.contents import MOST_A_RUN, changes
from pytest_hricdv.extra.suggestion.guards import guards
from pytest_hricdv.extra.suggestion.occurrences import events_of
from pytest_hricdv.extra.suggestion.orders import precedences, successions
from pytest_hricdv.extra.suggestion.relations import relations
from pytest_hricdv.extra.suggestion.responses import responses
from pytest_hricdv.extra.suggestion.views import Event, Runs
from pytest_hricdv.monitor import Requirement, RequirementError, parse_formula

MOST_EVENTS = 60
"""So many events are looked at, in pairs, at most: the broad ones first, then the most frequent (chosen)."""

MOST_OF_MESSAGE, MOST_OF_SOME, MOST_OF_OTHER = 14, 9, 5
"""So many candidates of a message that arrives, of some messages of a topic, and of another antecedent, are judged
(chosen)."""

MOST_CANDIDATES = 320
"""So many are judged: one takes some 3 ms for a run of the table, which a hundred faults have two of (chosen)."""


@dataclass(frozen=True)
class Parsed:
    """A candidate with its formula as data, to be judged."""

    candidate: Candidate
    requirement: Requirement


def candidates(runs: Runs) -> list[Parsed]:
    """Of all forms, in an order that depends on the runs only."""
    events = _kept(events_of(runs), len(runs.runs))
    made: dict[str, Candidate] = {}
    for candidate in (
        *responses(runs, events),
        *precedences(runs, events),
        *successions(runs),
        *changes(runs),
        *guards(runs, events),
        *relations(runs, events),
        *absences(runs, events),
        *bounds(runs),
    ):
        if candidate.support >= LEAST_SUPPORT:
            made.setdefault(candidate.formula, candidate)
    return [one for candidate in _worthy([*made.values()]) if (one := parsed(candidate, runs)) is not None]


def _worthy(made: Sequence[Candidate]) -> list[Candidate]:
    """The most worthy ones of each antecedent, and of those the most worthy: each is judged on each run."""
    kept: list[Candidate] = []
    count: dict[str, int] = {}
    for candidate in sorted(made, key=lambda one: (-one.worth, one.formula)):
        count[candidate.antecedent] = count.get(candidate.antecedent, 0) + 1
        if count[candidate.antecedent] <= _most_of(candidate.antecedent):
            kept.append(candidate)
    return kept[:MOST_CANDIDATES]


def _most_of(antecedent: str) -> int:
    """How many candidates of an antecedent are judged."""
    if not antecedent.startswith("on("):
        return MOST_OF_OTHER
    return MOST_OF_SOME if "&" in antecedent else MOST_OF_MESSAGE


def _kept(events: Sequence[Event], runs: int) -> list[Event]:
    usual = [event for event in events if event.count <= MOST_A_RUN * runs]
    usual.sort(key=lambda event: (event.is_state, event.narrow, -event.count, event.text))
    return usual[:MOST_EVENTS]


def parsed(candidate: Candidate, runs: Runs) -> Parsed | None:
    """A candidate with its formula as data; None for what can never hold, which the language refuses."""
    try:
        formula = parse_formula(candidate.formula, runs.vocabulary)
    except RequirementError:
        return None
    return Parsed(candidate, Requirement(candidate.formula, candidate.title, "", candidate.formula, formula))
