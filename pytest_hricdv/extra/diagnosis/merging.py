"""Causes of a merged report."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from zlib import decompress

from msgspec.structs import replace

from pytest_hricdv.extra.diagnosis.diagnosing import FOUND, NAME, Located, Subject, cause_of, ranked_places
from pytest_hricdv.extra.diagnosis.experiments import evidence_of
from pytest_hricdv.extra.diagnosis.grouping import Group
from pytest_hricdv.extra.diagnosis.records import CAUSES, DIAGNOSIS, DIAGNOSIS_ENDS, Cause, Decision
from pytest_hricdv.results.model import Report


def merge(reports: Sequence[Report], merged: Report) -> Report:
    """The merged report with the causes of all its failures: what experiments have shown is put together."""
    subject = Subject.of(merged)
    bases = [basis for report in reports if (basis := DIAGNOSIS.of(report)) is not None]
    if not subject.failures or not bases:
        return merged
    before = [cause for report in reports for cause in CAUSES.of(report)]
    experiments = tuple(dict.fromkeys(experiment for basis in bases for experiment in basis.experiments))
    evidence = evidence_of(experiments)
    made = (
        cause_of(
            subject, group, evidence, _decision_of(subject, group, before), Located(ranked_places(subject, group, ()))
        )
        for group in subject.groups(evidence)
    )
    basis = replace(
        bases[0],
        runs=sum(basis.runs for basis in bases),
        budget=sum(basis.budget for basis in bases),
        ended=max((basis.ended for basis in bases), key=DIAGNOSIS_ENDS.index),
        experiments=experiments,
    )
    return DIAGNOSIS.put(CAUSES.put(merged, tuple(_with_hints(cause, before) for cause in made)), basis)


def _decision_of(subject: Subject, group: Group, before: Sequence[Cause]) -> Decision | None:
    """What decides, of a cause of one of the reports, if the same failure is in this group."""
    failures = {(subject.tests[failure.nodeid].id, failure.requirement) for failure in group.failures}
    decided = (
        cause.decision
        for cause in before
        if cause.decision and any((cause.decision.test, name) in failures for name in cause.requirements)
    )
    return min(decided, key=lambda decision: (not decision.kind, len(decision.concrete)), default=None)


def _with_hints(cause: Cause, before: Sequence[Cause]) -> Cause:
    """With the hints of all reports, and the places of the one with most tests: there, runs were traced."""
    same = [other for other in before if other.id == cause.id]
    hints = dict.fromkeys(hint for other in same for hint in other.hints)
    largest = max(same, key=lambda other: len(other.tests), default=cause)
    return replace(cause, hints=tuple(hints), places=largest.places or cause.places)


def rebuilt(report: Report, kept: Mapping[str, Mapping[str, bytes]]) -> Report:
    """The report of a journal, with the causes that its session had found when it died."""
    packed = kept.get(NAME, {}).get(CAUSES.name)
    if packed is None:
        return report
    causes, basis = FOUND.decode(decompress(packed))
    return DIAGNOSIS.put(CAUSES.put(report, causes), basis)
