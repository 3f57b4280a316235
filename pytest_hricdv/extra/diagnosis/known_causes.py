"""Known violations whose entry names causes: those of another cause are new; a cause that nothing fails for is gone."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from pytest_hricdv.extra.diagnosis.diagnosing import Subject, id_of
from pytest_hricdv.extra.diagnosis.experiments import evidence_of
from pytest_hricdv.extra.diagnosis.grouping import Evidence
from pytest_hricdv.extra.diagnosis.records import DIAGNOSIS
from pytest_hricdv.report.formatting import plural
from pytest_hricdv.results.gates import Exemption
from pytest_hricdv.results.model import Report


def compared(report: Report, entries: Mapping[str, Exemption]) -> Iterator[tuple[bool, str]]:
    """What the causes of known violations are otherwise than entries say: whether it is new, and a sentence.

    Args:
        report: of all tests: association over a part of them may come to other causes.
        entries: requirement -> its entry; those that name no causes say nothing of them.
    """
    subject = Subject.of(report)
    diagnosis = DIAGNOSIS.of(report)
    evidence = Evidence() if diagnosis is None else evidence_of(diagnosis.experiments)
    groups = subject.groups(evidence)
    # Experiments are made only while something is new: what is named by association alone is meant, too.
    associated = groups if evidence == Evidence() else subject.groups(Evidence())
    otherwise = {failure: id_of(group) for group in associated for failure in group.failures}
    ids = {id_of(group) for group in groups} | {*otherwise.values()}
    for requirement, entry in entries.items():
        if not entry.causes:
            continue
        for group in groups:
            failing = [
                failure.nodeid
                for failure in group.failures
                if failure.requirement == requirement and failure.is_known and otherwise[failure] not in entry.causes
            ]
            if failing and id_of(group) not in entry.causes:
                tests = f"{plural(len(failing), 'test')} {'violates' if len(failing) == 1 else 'violate'}"
                yield (
                    True,
                    f"{requirement} is known of {_listed(entry)}, but {tests} it for cause {id_of(group)}, first "
                    f"{subject.tests[failing[0]].id}: mend it, or name it in hri_known_violations",
                )
        for name in entry.causes:
            if name not in ids:
                yield (
                    False,
                    f"{requirement} is known of cause {name}, which is gone: no test fails for it; take it out of "
                    "hri_known_violations",
                )


def _listed(entry: Exemption) -> str:
    word = "cause" if len(entry.causes) == 1 else "causes"
    return f"{word} {', '.join(entry.causes)}"
