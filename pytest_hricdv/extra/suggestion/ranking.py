"""Which candidates are worth a person's time, and in which order.

What a candidate is good for is measured: the seeded faults that it notices. A candidate that notices only what a better
one notices, of the same things, is redundant; one that no fault violates is shown last, and only where it excludes
much that could happen.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from pytest_hricdv.extra.suggestion.candidate import Candidate
from pytest_hricdv.extra.suggestion.checking import Tally
from pytest_hricdv.extra.suggestion.mining import Parsed

LEAST_SURPRISE = 0.25
"""A candidate that no fault violates has to exclude so much (chosen)."""

OF_STATE = 0.4
"""What is said of the code's own state counts so much: people ask for what a robot does. Chosen: of the table's first
twenty five were of states, without it."""

MOST_ALIKE = 2
"""Of candidates that notice nothing new, so many are shown of one event; of those that notice something that others do,
one more (chosen). None is shown that asks for what is asked for already, or that is of the code's state."""

MOST_PARTS = 3
"""Conditions of one event are one requirement, of so many parts at most, so that people can read it (chosen)."""


@dataclass(frozen=True)
class Rated:
    """A candidate with what runs say of it.

    Args:
        parsed: the candidate.
        tally: of the runs that it was learnt of.
        killed: the runs of seeded faults that it fails, by their numbers, as bits.
        faults: the seeded faults that it notices, as bits.
        new: those of them that nothing else notices, as bits.
    """

    parsed: Parsed
    tally: Tally
    killed: int = 0
    faults: int = 0
    new: int = 0

    @classmethod
    def known(cls, parsed: Parsed, killed: int) -> Rated:
        """A requirement that there is already."""
        return cls(parsed, Tally(), killed)

    @property
    def candidate(self) -> Candidate:
        """What is rated."""
        return self.parsed.candidate


def ranked(rated: Sequence[Rated], taken: int = 0, known: Sequence[Rated] = ()) -> list[Rated]:
    """In the order in which they are shown, without what is redundant.

    Args:
        rated: candidates that hold.
        taken: faults that requirements notice already, as bits.
        known: these requirements.
    """
    left = sorted(rated, key=lambda one: (-one.candidate.worth, len(one.candidate.formula), one.candidate.formula))
    shown: list[Rated] = []
    times = Counter(_numbers(taken))
    while left:
        best = max(left, key=lambda one: (_gain(one, times), bool(one.new), one.candidate.worth))
        left.remove(best)
        if any(not times[number] for number in _numbers(best.faults)) or not _is_redundant(best, [*known, *shown]):
            shown.append(best)
            times.update(_numbers(best.faults))
    return shown


def _gain(one: Rated, times: Mapping[int, int]) -> float:
    """How much it is worth to notice its faults: one that is noticed so many times already counts half for each.

    The seeded faults stand for others. What notices five of a kind will notice a sixth, though others notice the five.
    """
    weight = OF_STATE if one.candidate.of_state else 1.0
    return weight * sum(0.5 ** times[number] for number in _numbers(one.faults))


def _numbers(faults: int) -> Iterator[int]:
    """The numbers of faults that are written as bits."""
    return (number for number in range(faults.bit_length()) if faults >> number & 1)


def _is_redundant(one: Rated, shown: Sequence[Rated]) -> bool:
    mine = one.candidate
    related = [other for other in shown if _are_related(mine, other.candidate)]
    reacting = [other for other in shown if other.candidate.reaction == mine.reaction]
    asking = [other for other in shown if other.candidate.antecedent == mine.antecedent]
    if reacting or len(asking) > MOST_ALIKE or mine.of_state:
        return True
    if one.killed:
        return any(one.killed & ~other.killed == 0 for other in related)
    if mine.surprise < LEAST_SURPRISE:
        return True
    return len(asking) >= MOST_ALIKE or any(other.candidate.subjects >= mine.subjects for other in related)


def _are_related(one: Candidate, other: Candidate) -> bool:
    """Whether they ask for something at the same event, or are about the same things."""
    if one.antecedent == other.antecedent or one.response == other.response:
        return True
    return one.form == other.form and one.subjects <= other.subjects


def joined(rated: Iterable[Rated]) -> list[tuple[Candidate, tuple[Rated, ...]]]:
    """Conditions at one event as one candidate: the parts that notice the most first; with the parts."""
    by_event: dict[str, list[Rated]] = {}
    for one in rated:
        if one.candidate.form == "at event":
            by_event.setdefault(one.candidate.antecedent, []).append(one)
    made = []
    for parts in by_event.values():
        chosen = _parts(parts)
        if len(chosen) > 1:
            made.append((_conjunction([part.candidate for part in chosen]), tuple(chosen)))
    return made


def _parts(parts: Sequence[Rated]) -> list[Rated]:
    left, noticed = [*parts], 0
    chosen: list[Rated] = []
    while left and len(chosen) < MOST_PARTS:
        best = max(left, key=lambda one: ((one.killed & ~noticed).bit_count(), one.candidate.surprise))
        left.remove(best)
        subjects, is_number = (
            best.candidate.subjects,
            "<=" in best.candidate.response or ">=" in best.candidate.response,
        )
        says_much = best.candidate.surprise >= 0.5 and not is_number
        if best.killed & ~noticed or (says_much and all(other.candidate.subjects != subjects for other in chosen)):
            chosen.append(best)
            noticed |= best.killed
    return chosen


def _conjunction(parts: Sequence[Candidate]) -> Candidate:
    first = parts[0]
    texts = [f"({part.response})" if "|" in part.response else part.response for part in parts]
    events = [part.title.removesuffix(" only").partition(" happens ")[2] for part in parts]
    listed = ", ".join(events[:-1]) + f" and {events[-1]}"
    return replace(
        first,
        title=f"{first.title.partition(' happens ')[0]} happens {listed} only",
        response=" & ".join(texts),
        subjects=frozenset().union(*(part.subjects for part in parts)),
        observed="; ".join(dict.fromkeys(part.observed for part in parts if part.observed)),
        surprise=max(part.surprise for part in parts),
    )


def bits(numbers: Iterable[int]) -> int:
    """A set of numbers as bits."""
    made = 0
    for number in numbers:
        made |= 1 << number
    return made


def weaker_bounds(rated: Sequence[Rated], shares: Mapping[str, float]) -> list[Rated]:
    """Without bounds that another one says for a longer time: of those with one response, that of the longest time.

    Args:
        rated: candidates that hold.
        shares: antecedent -> of which part of the time it holds.
    """
    best: dict[str, Rated] = {}
    for one in rated:
        if one.candidate.form == "bound":
            other = best.get(one.candidate.response)
            mine = (one.faults.bit_count(), shares.get(one.candidate.antecedent, 0.0))
            if other is None or mine > (other.faults.bit_count(), shares.get(other.candidate.antecedent, 0.0)):
                best[one.candidate.response] = one
    return [one for one in rated if one.candidate.form != "bound" or best[one.candidate.response] is one]
