"""`mine`: makes candidates that all runs satisfy, and ranks them by the seeded bugs that violate them.

`Suggester` calls it after the runs were recorded, and gets a `CandidatePool` with a `CandidateScore` for each.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

from pytest_hricdv.extra.suggestion.bounds import bounds
from pytest_hricdv.extra.suggestion.candidate import MIN_SUPPORT, RequirementCandidate
from pytest_hricdv.extra.suggestion.events import Runs, find_events
from pytest_hricdv.extra.suggestion.order_templates import absences, precedences, responses
from pytest_hricdv.extra.suggestion.stored_run import StoredRun
from pytest_hricdv.monitor import Log, MonitorError, Requirement, RequirementError, Verdict, evaluate, parse_formula

MAX_CANDIDATES = 320
"""Maximum number of candidates to judge, the most useful first: each takes 3 ms for a run of the case study."""

STATE_WEIGHT = 0.4
"""Weight of bugs that violate a candidate about the code's own state, compared to one about what the robot does, which
matters to people. Without it, five of the case study's first twenty suggestions were about states."""


@dataclass
class Tally:
    """Counts of the runs that checked a candidate.

    Attributes:
        triggers: how often it asked for something.
        decisive: number of runs in which it passed.
        failed: number of runs in which it was violated.
        least: its least margin, in its unit; None where nothing was compared.
    """

    triggers: int = 0
    decisive: int = 0
    failed: int = 0
    least: float | None = None

    def add(self, verdict: Verdict) -> None:
        """Count a run."""
        self.triggers += verdict.triggers
        self.decisive += verdict.verdict == "Passed"
        self.failed += verdict.verdict == "Failed"
        if verdict.margin is not None and (self.least is None or verdict.margin < self.least):
            self.least = verdict.margin


@dataclass(frozen=True)
class CandidateScore:
    """A candidate with its tally.

    Args:
        requirement: its formula as data.
        tally: the tally of the runs that it was mined from.
        faults: the seeded bugs that violate it, as bits.
        new: those of them that nothing else notices, as bits.
    """

    candidate: RequirementCandidate
    requirement: Requirement
    tally: Tally
    faults: int = 0
    new: int = 0


@dataclass(frozen=True)
class CandidatePool:
    """The candidates that no run has refuted.

    Args:
        scores: the scores of candidates that all runs satisfy.
        noticed: the seeded bugs that requirements or exceptions notice, as bits.
        candidates: how many there were at first.
    """

    scores: tuple[CandidateScore, ...]
    noticed: int
    candidates: int

    @property
    def refutation_count(self) -> int:
        """The number of candidates that were dropped."""
        return self.candidates - len(self.scores)

    def rank(self) -> list[CandidateScore]:
        """The candidates in the order in which they are shown, without redundant ones."""
        return rank(self.scores, self.noticed)

    def drop(self, formulas: Collection[str]) -> CandidatePool:
        """The result without these candidates."""
        return replace(self, scores=tuple(score for score in self.scores if score.candidate.formula not in formulas))


def list_open_tests(shown: Sequence[CandidateScore], runs: Sequence[StoredRun]) -> list[str]:
    """The tests of runs at whose end one of these candidates still waits for what it asks for."""
    judge, requirements = _Judge(), [score.requirement for score in shown]
    return [run.test for run in runs if any(verdict.pending for verdict in judge.judge(requirements, run.log()))]


def mine(runs: Runs, faults: Sequence[Sequence[StoredRun]], requirements: Collection[str]) -> CandidatePool:
    """The candidates that all runs satisfy, with the seeded bugs that violate them.

    Args:
        runs: runs of the original code.
        faults: for each seeded bug, the runs that it changes.
        requirements: ids of the requirements that there are.
    """
    names = {*requirements}
    noticed = bits(
        number
        for number, changed in enumerate(faults)
        if any(run.errors or not names.isdisjoint(run.failed) for run in changed)
    )
    judge, candidates = _Judge(), {candidate.formula: candidate for candidate in find_candidates(runs)}
    parsed = [one for candidate in candidates.values() if (one := _parse(candidate, runs)) is not None]
    tallies = judge.tally(parsed, runs.logs)
    held = [one for one in parsed if (tally := tallies.get(one.id)) and tally.decisive and not tally.failed]
    violated: dict[str, set[int]] = {one.id: set() for one in held}
    for number, changed in enumerate(faults):
        # One run is enough for a bug that is detected anyway.
        for run in changed[:1] if noticed >> number & 1 else changed:
            for verdict in judge.judge(held, run.log()) if run.has_record else ():
                if verdict.verdict == "Failed":
                    violated[verdict.requirement].add(number)
    scores = tuple(
        CandidateScore(candidates[one.id], one, tallies[one.id], caught := bits(violated[one.id]), caught & ~noticed)
        for one in held
        if one.id not in judge.broken
    )
    return CandidatePool(scores, noticed, len(scores))


def find_candidates(runs: Runs) -> list[RequirementCandidate]:
    """Candidates of all templates, the most useful first."""
    events = find_events(runs)
    made: dict[str, RequirementCandidate] = {}
    for candidate in (*responses(runs, events), *precedences(events), *absences(runs, events), *bounds(runs)):
        if candidate.support >= MIN_SUPPORT:
            made.setdefault(candidate.formula, candidate)
    return sorted(made.values(), key=_usefulness)[:MAX_CANDIDATES]


def _usefulness(candidate: RequirementCandidate) -> tuple[bool, bool, float, str]:
    is_outside, is_of_message, surprise = candidate.worth
    return not is_outside, not is_of_message, -surprise, candidate.formula


def _parse(candidate: RequirementCandidate, runs: Runs) -> Requirement | None:
    """None for what can never hold, which the language refuses."""
    try:
        formula = parse_formula(candidate.formula, runs.vocabulary)
    except RequirementError:
        return None
    return Requirement(candidate.formula, candidate.title, "", candidate.formula, formula)


@dataclass
class _Judge:
    """Judges logs by candidates; a candidate that reads what a log does not have is broken, and left out."""

    broken: set[str] = field(default_factory=set)

    def judge(self, requirements: Iterable[Requirement], log: Log) -> list[Verdict]:
        wanted = [requirement for requirement in requirements if requirement.id not in self.broken]
        try:
            return [*evaluate(wanted, log)]
        except MonitorError:
            verdicts: list[Verdict] = []
            for requirement in wanted:
                try:
                    verdicts += evaluate([requirement], log)
                except MonitorError:
                    self.broken.add(requirement.id)
            return verdicts

    def tally(self, requirements: Sequence[Requirement], logs: Iterable[Log]) -> dict[str, Tally]:
        """Formula -> what these runs say about it."""
        tallies = {requirement.id: Tally() for requirement in requirements}
        for log in logs:
            for verdict in self.judge(requirements, log):
                tallies[verdict.requirement].add(verdict)
        return {formula: tally for formula, tally in tallies.items() if formula not in self.broken}


def rank(scores: Iterable[CandidateScore], noticed: int = 0) -> list[CandidateScore]:
    """Rank candidates in the order in which they are shown, without redundant ones.

    A seeded bug represents others: a candidate that detects five of a kind will detect a sixth. So a detected bug
    counts half for each requirement or candidate above that detects it. Where no bug was tried, the most useful come
    first.

    Args:
        noticed: the bugs that requirements notice, as bits.
    """
    left = sorted(scores, key=lambda score: _usefulness(score.candidate))
    if any(score.faults for score in left):
        left = [score for score in left if score.faults]
    shown: list[CandidateScore] = []
    times = Counter(_numbers(noticed))

    def gain(score: CandidateScore) -> float:
        weight = STATE_WEIGHT if score.candidate.of_state else 1.0
        return weight * sum(0.5 ** times[number] for number in _numbers(score.faults))

    while left:
        best = max(left, key=gain)
        left.remove(best)
        is_new = any(not times[number] for number in _numbers(best.faults))
        if is_new or not any(_are_related(best.candidate, other.candidate) for other in shown):
            shown.append(best)
            times.update(_numbers(best.faults))
    return shown


def _are_related(one: RequirementCandidate, other: RequirementCandidate) -> bool:
    """Whether they react to the same event, ask for the same, or are about the same things."""
    if one.antecedent == other.antecedent or one.reaction == other.reaction:
        return True
    return one.form == other.form and one.subjects <= other.subjects


def _numbers(faults: int) -> Iterator[int]:
    return (number for number in range(faults.bit_length()) if faults >> number & 1)


def bits(numbers: Iterable[int]) -> int:
    """A set of numbers as bits."""
    return sum(1 << number for number in {*numbers})
