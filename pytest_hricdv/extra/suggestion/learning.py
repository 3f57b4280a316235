"""What is learnt of runs: the candidates that they satisfy, rated by the runs of seeded faults."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

from pytest_hricdv.extra.suggestion.candidate import Candidate
from pytest_hricdv.extra.suggestion.checking import Judging
from pytest_hricdv.extra.suggestion.mining import Parsed, candidates, parsed
from pytest_hricdv.extra.suggestion.occurrences import signal_conditions, state_conditions
from pytest_hricdv.extra.suggestion.ranking import Rated, joined, ranked, weaker_bounds
from pytest_hricdv.extra.suggestion.stored_run import StoredRun
from pytest_hricdv.extra.suggestion.views import Runs
from pytest_hricdv.monitor import Requirement
from pytest_hricdv.monitor.analysis import names_read, topics_read

LEAST_MOVED = 0.2
"""Where faults move a signal in fewer of their runs, the code under test has little to do with it (chosen)."""

LEAST_COMPARED = 5
"""Of fewer runs, that is not told (chosen)."""


@dataclass(frozen=True)
class Evidence:
    """What is learnt of.

    Args:
        runs: without a fault.
        faulty: of each fault that changes any, the runs that it changes.
        requirements: that there are already, and are taken into account.
        compared: that suggestions are only compared with.
    """

    runs: Runs
    faulty: tuple[tuple[StoredRun, ...], ...] = ()
    requirements: tuple[Requirement, ...] = ()
    compared: tuple[Requirement, ...] = ()

    @property
    def taken(self) -> int:
        """The faults that requirements notice already, or that end a run by themselves, as bits."""
        names = {requirement.id for requirement in self.requirements}
        made = 0
        for number, runs in enumerate(self.faulty):
            if any(run.faults or not names.isdisjoint(run.failed) for run in runs):
                made |= 1 << number
        return made


@dataclass(frozen=True)
class Learnt:
    """What was learnt.

    Args:
        evidence: that it was learnt of.
        rated: the candidates that its runs satisfy.
        candidates: how many there were, before conditions of one event were put together.
        refuted: how many of them later runs refuted.
        further: formula -> how many later runs checked it.
    """

    evidence: Evidence
    rated: tuple[Rated, ...]
    candidates: int
    refuted: int = 0
    further: Mapping[str, int] = field(default_factory=dict)

    @property
    def ranked(self) -> list[Rated]:
        """In the order in which they are shown, without redundant ones."""
        runs, taken = self.evidence.runs, self.evidence.taken
        shares = {condition.text: condition.share for condition in (*signal_conditions(runs), *state_conditions(runs))}
        rated = weaker_bounds(_with_joined(self.rated, runs, taken), shares)
        return ranked(rated, taken, known(self.evidence.requirements, self.evidence))

    def without(self, runs: Sequence[StoredRun]) -> Learnt:
        """Those that these runs do not refute."""
        judging = Judging([one.parsed for one in self.rated])
        tallies = judging.tallies((run.test, run.log()) for run in runs)
        left = tuple(
            one for one in self.rated if (tally := tallies.get(one.candidate.formula)) is not None and not tally.failed
        )
        further = {formula: tally.decisive for formula, tally in tallies.items()}
        return replace(self, rated=left, refuted=len(self.rated) - len(left), further=further)

    def without_formulas(self, formulas: Collection[str]) -> Learnt:
        """Those that are none of these, which were refuted."""
        left = tuple(one for one in self.rated if one.candidate.formula not in formulas)
        return replace(self, rated=left, refuted=self.refuted + len(self.rated) - len(left))

    def undecided(self, shown: Sequence[Rated], runs: Sequence[StoredRun]) -> list[str]:
        """The tests of those runs at whose end one of these still waits for what it asks for."""
        judging = Judging([one.parsed for one in shown])
        return [run.test for run in runs if any(verdict.pending for verdict in judging.verdicts(run.log()).values())]


def learnt(evidence: Evidence) -> Learnt:
    """The candidates that runs satisfy, and the seeded faults that each notices."""
    runs = evidence.runs
    judging = Judging(candidates(runs))
    tallies = judging.tallies(zip((run.test for run in runs.runs), runs.logs, strict=True))
    satisfied = [
        one
        for one in judging.candidates
        if (tally := tallies.get(one.candidate.formula)) is not None and tally.decisive and not tally.failed
    ]
    killed = dict.fromkeys((one.candidate.formula for one in satisfied), 0)
    faults = dict(killed)
    place = 0
    for number, changed in enumerate(evidence.faulty):
        is_taken = evidence.taken >> number & 1
        for run in changed:
            # Of a fault that is noticed anyway, one run tells enough.
            if run.has_record and not (is_taken and run is not changed[0]):
                for formula, verdict in judging.verdicts(run.log(), satisfied).items():
                    if verdict.verdict == "Failed":
                        killed[formula] |= 1 << place
                        faults[formula] |= 1 << number
            place += 1
    rated = (
        Rated(one, tallies[formula], killed[formula], faults[formula], faults[formula] & ~evidence.taken)
        for one in satisfied
        if (formula := one.candidate.formula) not in judging.dropped
    )
    return Learnt(evidence, tuple(rated), len(satisfied))


def _with_joined(rated: Sequence[Rated], runs: Runs, taken: int) -> list[Rated]:
    """With the conditions of one event as one; those that are in it, or that notice nothing more, are left out."""
    made, of_event = [], {}
    for candidate, parts in joined(rated):
        whole = parsed(candidate, runs)
        if whole is None:
            continue
        killed = faults = 0
        for part in parts:
            killed, faults = killed | part.killed, faults | part.faults
        made.append(Rated(whole, parts[0].tally, killed, faults, faults & ~taken))
        of_event[candidate.antecedent] = killed
    return [
        *made,
        *(
            one
            for one in rated
            if one.candidate.form != "at event"
            or one.candidate.antecedent not in of_event
            or one.killed & ~of_event[one.candidate.antecedent]
        ),
    ]


ALIKE = 0.5
"""A suggestion is like a requirement where it fails in so many of the runs in which this fails (chosen)."""


def alike(rated: Rated, evidence: Evidence) -> tuple[str, ...]:
    """The requirements that a suggestion is like: of those that some fault violates, and that are about the same."""
    subjects = rated.candidate.subjects
    return tuple(
        requirement
        for other in known(evidence.compared, evidence)
        if other.killed
        and not subjects.isdisjoint(other.candidate.subjects)
        and (rated.killed & other.killed).bit_count() >= ALIKE * other.killed.bit_count()
        and (requirement := other.parsed.requirement.id)
    )


def known(requirements: Sequence[Requirement], evidence: Evidence) -> list[Rated]:
    """Requirements that there are, as what is shown already."""
    places = [run for changed in evidence.faulty for run in changed]
    made = []
    for requirement in requirements:
        names = {name.partition(".")[0] for name in names_read(requirement.formula)}
        subjects = frozenset(names | {*topics_read(requirement.formula)})
        texts = str(requirement.formula.antecedent), str(requirement.formula.response)
        candidate = Candidate("response", requirement.title, *texts, subjects, 0)
        killed = sum(1 << place for place, run in enumerate(places) if requirement.id in run.failed)
        made.append(Rated.known(Parsed(candidate, requirement), killed))
    return made


def unmoved(own: Mapping[str, StoredRun], faulty: Iterable[Sequence[StoredRun]]) -> frozenset[str]:
    """The signals that the code under test has little to do with: faults in it hardly move them.

    Args:
        own: test -> its run without a fault.
        faulty: of each fault, the runs that it changes.
    """
    moved: dict[str, int] = {}
    compared = 0
    for changed in faulty:
        for run in changed:
            before = own.get(run.test)
            if before is None or not run.has_record:
                continue
            compared += 1
            end_s = min(run.end_s, before.end_s)
            one, other = run.log(), before.log()
            for name in {*one.signals, *other.signals}:
                pair = [_until(log.signals.get(name, ((), ())), end_s) for log in (one, other)]
                moved[name] = moved.get(name, 0) + (pair[0] != pair[1])
    if compared < LEAST_COMPARED:
        return frozenset()
    return frozenset(name for name, count in moved.items() if count < LEAST_MOVED * compared)


def _until(series: tuple[Sequence[float], Sequence[object]], end_s: float) -> list[tuple[float, object]]:
    return [(time_s, value) for time_s, value in zip(*series, strict=True) if time_s <= end_s]
