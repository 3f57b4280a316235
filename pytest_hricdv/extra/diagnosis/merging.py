"""Causes of reports that no session diagnosed: merged reports, reports of campaigns, and those rebuilt from journals.

The core calls `merge`, `associate` and `rebuilt` for these reports (see `registry`). Merged reports use the experiments
of all their parts. Campaigns make no experiments, so their causes rest on association only.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from zlib import decompress

from msgspec.structs import replace

from pytest_hricdv.extra.diagnosis.causes import FOUND, NAME, cause_of
from pytest_hricdv.extra.diagnosis.experiments import evidence_of
from pytest_hricdv.extra.diagnosis.grouping import ExperimentEvidence, Group
from pytest_hricdv.extra.diagnosis.locations import rank_places
from pytest_hricdv.extra.diagnosis.records import CAUSES, DIAGNOSIS, DIAGNOSIS_ENDS, Cause, Decision, Probability
from pytest_hricdv.extra.diagnosis.subject import Subject
from pytest_hricdv.results.codec import canonical
from pytest_hricdv.results.model import Report
from pytest_hricdv.results.proportion import share


def merge(reports: Sequence[Report], merged: Report) -> Report:
    """The merged report with the causes of all its failures, by the experiments of all reports."""
    subject = Subject.of(merged)
    by_text = {canonical(basis): basis for report in reports if (basis := DIAGNOSIS.of(report)) is not None}
    bases = [by_text[text] for text in sorted(by_text)]  # the same in any order, and a report twice counts once
    if not subject.failures or not bases:
        return merged
    before = [cause for report in reports for cause in CAUSES.of(report)]
    unique = dict.fromkeys(experiment for basis in bases for experiment in basis.experiments)
    experiments = tuple(sorted(unique, key=canonical))
    evidence = evidence_of(experiments)
    causes = (
        cause_of(subject, group, evidence, _decision_of(subject, group, before), rank_places(subject, group, ()))
        for group in subject.groups(evidence)
    )
    basis = replace(
        bases[0],
        runs=sum(basis.runs for basis in bases),
        budget=sum(basis.budget for basis in bases),
        end_reason=max((basis.end_reason for basis in bases), key=DIAGNOSIS_ENDS.index),
        experiments=experiments,
    )
    return DIAGNOSIS.put(CAUSES.put(merged, tuple(_add_trace(cause, before) for cause in causes)), basis)


def _decision_of(subject: Subject, group: Group, before: Sequence[Cause]) -> Decision | None:
    """The deciding change that a report found for a failure of this group; None if none did."""
    failures = {(subject.tests[failure.nodeid].id, failure.requirement) for failure in group.failures}
    decided = (
        cause.minimal_pair
        for cause in before
        if cause.minimal_pair and any((cause.minimal_pair.test, name) in failures for name in cause.requirements)
    )
    return min(
        decided,
        key=lambda decision: (not decision.kind, decision.untriggered, len(decision.concrete), canonical(decision)),
        default=None,
    )


def _add_trace(cause: Cause, before: Sequence[Cause]) -> Cause:
    """The cause with the locations that the report with most of its tests found by tracing runs."""
    same = sorted((other for other in before if other.id == cause.id), key=canonical)
    largest = max(same, key=lambda other: (len(other.tests), canonical(other)), default=cause)
    cause = replace(cause, locations=largest.locations or cause.locations)
    left = next((other for other in same if other.is_shrunk and other.minimal_of in cause.tests), None)
    if left is None:
        return cause
    return replace(cause, minimal=left.minimal, minimal_of=left.minimal_of, is_shrunk=True, replay=left.replay)


def associate(report: Report, *, is_of_all_runs: bool) -> Report:
    """The report of a campaign with the causes of its failures, by association over its runs, without experiments.

    Args:
        is_of_all_runs: whether the report lists all runs, so the probability of each cause is known.
    """
    subject = Subject.of(report)
    if not any(test.fails for test in report.tests) or not subject.failures:
        return report
    causes = (
        cause_of(subject, group, ExperimentEvidence(), None, rank_places(subject, group, ()))
        for group in subject.groups(ExperimentEvidence())
    )
    runs = len(subject.tests) if is_of_all_runs else 0
    return CAUSES.put(report, tuple(replace(cause, probability=_probability(cause, runs)) for cause in causes))


def _probability(cause: Cause, runs: int) -> Probability | None:
    interval = share(min(len(cause.tests), runs), runs)
    if interval is None:
        return None
    low, high = round(100 * interval.low, 4), round(100 * interval.high, 4)
    return Probability(runs=runs, failing=len(cause.tests), low=low, high=high)


def rebuilt(report: Report, kept: Mapping[str, Mapping[str, bytes]]) -> Report:
    """The report of a journal, with the causes that its session had found when it died."""
    packed = kept.get(NAME, {}).get(CAUSES.name)
    if packed is None:
        return report
    causes, basis = FOUND.decode(decompress(packed))
    return DIAGNOSIS.put(CAUSES.put(report, causes), basis)
