"""Locations: where in the code under test a cause probably is, and where its nodes were at the violation."""

from __future__ import annotations

from collections.abc import Sequence

from pytest_hricdv.coverage.code_map import Bits
from pytest_hricdv.coverage.gaps import Function, functions
from pytest_hricdv.extra.diagnosis.experiments import Experiments
from pytest_hricdv.extra.diagnosis.failures import FAULT, Failure
from pytest_hricdv.extra.diagnosis.grouping import Group
from pytest_hricdv.extra.diagnosis.places import weight_suspects
from pytest_hricdv.extra.diagnosis.records import SuspiciousPlace
from pytest_hricdv.extra.diagnosis.spectrum import Spectra, Suspect, combine
from pytest_hricdv.extra.diagnosis.subject import Subject
from pytest_hricdv.extra.diagnosis.switching import SWITCHED
from pytest_hricdv.extra.diagnosis.trace import ViolationTrace

MAX_PLACES = 5
"""The number of statements that a report lists, the most suspicious first."""

MAX_SWITCHED = 2
"""If more decisions let tests pass, reversed, none of them says much: the function of the first was the faulty one for
7 of 9 faults with one such decision, for 2 of 4 with two, and for 3 of 5 with more (37 faults in three testbenches, one
of them held out)."""

LIKELY = 0.7
"""The least score of a statement that is shown: of 45 faults in three testbenches, one of them held out, 20 have such a
statement, in the faulty function for 15. From 0.5 on, two in three were right."""


def traces_of(experiments: Experiments, group: Group) -> list[ViolationTrace]:
    """Traces of runs that failed for a cause, up to the first failure; known ones count only if nothing else failed."""
    first: dict[str, Failure] = {}
    for failure in sorted(group.failures, key=lambda failure: failure.is_known):
        first.setdefault(failure.nodeid, failure)
    runs = ((failure.requirement, experiments.controls.get(name)) for name, failure in first.items())
    return [run.traces[requirement] for requirement, run in runs if run is not None and requirement in run.traces]


def variation_coverage(experiments: Experiments, group: Group) -> list[tuple[Bits, bool]]:
    """Coverage of runs that vary a cause's tests, and whether they failed for it; other runs show nothing."""
    shown = []
    for result in (result for name in group.nodeids for result in experiments.runs.get(name, ())):
        bits, fails = Bits.of(result.code), not {*group.requirements}.isdisjoint(result.violated)
        passes = not result.violated and group.first[0] in (FAULT, *result.checked)
        if bits is not None and (fails or passes):
            shown.append((bits, fails))
    return shown


def rank_places(
    subject: Subject,
    group: Group,
    traces: Sequence[ViolationTrace],
    varied: Sequence[tuple[Bits, bool]] = (),
    switched: Sequence[tuple[str, int]] = (),
) -> list[Suspect]:
    """The statements of the code, those first in which a cause is probably.

    Args:
        subject: what the failures are of.
        group: that have the cause.
        traces: of runs that failed for it, up to what failed first.
        varied: what runs of variations of its tests executed, and whether they failed for it.
        switched: file and line of decisions with which tests of it pass, reversed.
    """
    code = subject.spectra.code
    suspects = subject.spectra.suspects(group.nodeids, subject.find_violators(group))
    if {fails for _, fails in varied} == {True, False}:
        spectra = Spectra(code, {str(number): bits for number, (bits, _) in enumerate(varied)})
        failing = [str(number) for number, (_, fails) in enumerate(varied) if fails]
        suspects = combine(suspects, spectra, failing)
    return weight_suspects(suspects, traces, () if code is None else code.files, switched)


def locate(
    subject: Subject, ranked: Sequence[Suspect], switched: Sequence[tuple[str, int]], *, is_compared: bool
) -> tuple[SuspiciousPlace, ...]:
    """The most suspicious statements, as a report has them.

    Args:
        subject: whose code they are of.
        ranked: the most suspicious first.
        switched: file and line of decisions with which tests pass, reversed.
        is_compared: the code was measured in a run that fails for the cause, and in one that passes.
    """
    sources = {file.file: file.source for file in subject.report.code_under_test.map}
    return tuple(
        SuspiciousPlace(
            file=suspect.file,
            line=suspect.line,
            function=_function(functions(sources[suspect.file]), suspect.line),
            score=round(suspect.score, 4),
            likely=number == 0
            and suspect.score >= LIKELY
            and len(switched) <= MAX_SWITCHED
            and (is_compared or (suspect.file, suspect.line) in switched),
            experiment=SWITCHED if (suspect.file, suspect.line) in switched else "",
            text=_line(sources[suspect.file], suspect.line),
        )
        for number, suspect in enumerate(ranked[:MAX_PLACES])
    )


def node_places(subject: Subject, traces: Sequence[ViolationTrace]) -> tuple[str, ...]:
    """The innermost statements where the code of a run raised, or where its nodes were."""
    sources = {file.file: file.source for file in subject.report.code_under_test.map}
    for trace in traces[:1]:
        stood = [trace.raised] if trace.raised else [stack[0] for stack in trace.stood if stack]
        return tuple(f"{file}:{line} in {_function(functions(sources[file]), line)}" for file, line in stood)
    return ()


def _function(all_functions: Sequence[Function], line: int) -> str:
    return next(function.name for function in all_functions if line in function)


def _line(source: str, number: int) -> str:
    lines = source.splitlines()
    return lines[number - 1].strip() if number <= len(lines) else ""
