"""Locations: where in the code under test a cause probably is, and where its nodes were at the violation."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from pytest_hricdv.coverage.code_map import Bits
from pytest_hricdv.coverage.gaps import Function, functions
from pytest_hricdv.coverage.records import MappedFile
from pytest_hricdv.extra.diagnosis.experiments import Experiments
from pytest_hricdv.extra.diagnosis.failures import FAULT, Failure
from pytest_hricdv.extra.diagnosis.grouping import Group
from pytest_hricdv.extra.diagnosis.places import weight_suspects
from pytest_hricdv.extra.diagnosis.records import SuspiciousPlace
from pytest_hricdv.extra.diagnosis.spectrum import Spectra, Suspect, combine
from pytest_hricdv.extra.diagnosis.subject import Subject
from pytest_hricdv.extra.diagnosis.switching import SWITCHED, SwitchResult
from pytest_hricdv.extra.diagnosis.trace import ViolationTrace

_DECISION = re.compile(r"(if|elif|while|assert)\b")

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
    """Of runs that failed for a cause, up to what failed first; of what is known only where nothing else failed."""
    first: dict[str, Failure] = {}
    for failure in sorted(group.failures, key=lambda failure: failure.is_known):
        first.setdefault(failure.nodeid, failure)
    runs = ((failure.requirement, experiments.controls.get(name)) for name, failure in first.items())
    return [run.traces[requirement] for requirement, run in runs if run is not None and requirement in run.traces]


def variation_coverage(experiments: Experiments, group: Group) -> list[tuple[Bits, bool]]:
    """What runs of variations of a cause's tests executed, and whether they failed for it; others show nothing."""
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
    switched: Sequence[SwitchResult] = (),
) -> list[Suspect]:
    """The statements of the code, those first in which a cause is probably.

    Args:
        subject: what the failures are of.
        group: that have the cause.
        traces: of runs that failed for it, up to what failed first.
        varied: what runs of variations of its tests executed, and whether they failed for it.
        switched: decisions with which tests of it pass, reversed, the best first.
    """
    code = subject.spectra.code
    suspects = subject.spectra.suspects(group.nodeids, subject.find_violators(group))
    if {fails for _, fails in varied} == {True, False}:
        spectra = Spectra(code, {str(number): bits for number, (bits, _) in enumerate(varied)})
        failing = [str(number) for number, (_, fails) in enumerate(varied) if fails]
        suspects = combine(suspects, spectra, failing)
    return weight_suspects(suspects, traces, () if code is None else code.files, [found.place for found in switched])


def locate(
    subject: Subject,
    ranked: Sequence[Suspect],
    switched: Sequence[SwitchResult],
    traces: Sequence[ViolationTrace],
    *,
    is_compared: bool,
) -> tuple[SuspiciousPlace, ...]:
    """The most suspicious statements, as a report has them.

    Args:
        subject: whose code they are of.
        ranked: the most suspicious first.
        switched: decisions with which tests pass, reversed, the best first.
        traces: of runs that failed.
        is_compared: the code was measured in a run that fails for the cause, and in one that passes.
    """
    sources = {file.file: file.source for file in subject.report.code_under_test.map}
    shown = [found.place for found in switched]
    says, places = _says(subject, traces), []
    for number, suspect in enumerate(ranked[:MAX_PLACES]):
        function = _function(functions(sources[suspect.file]), suspect.line)
        is_clear = is_compared and suspect.score >= LIKELY and (suspect.file, function) not in says
        place = SuspiciousPlace(
            file=suspect.file,
            line=suspect.line,
            function=function,
            score=round(suspect.score, 4),
            likely=number == 0 and (is_sure(switched) if switched else is_clear),
            experiment=SWITCHED if (suspect.file, suspect.line) in shown else "",
            text=_line(sources[suspect.file], suspect.line),
        )
        places.append(place)
    return tuple(places)


def is_sure(switched: Sequence[SwitchResult]) -> bool:
    """Whether the first of decisions says where the cause is.

    Others pass on what it decides; or there are few, and with it the robot does all else as before: one that rests
    passes, too.
    """
    return any(found.callers or (len(switched) <= MAX_SWITCHED and not found.changes) for found in switched[:1])


def _says(subject: Subject, traces: Sequence[ViolationTrace]) -> set[tuple[str, str]]:
    """File and function of what sent the messages with which runs failed: it says what was decided before."""
    sources = {file.file: functions(file.source) for file in subject.report.code_under_test.map}
    sent = (trace.executed[0] for trace in traces if trace.is_said and trace.executed)
    return {(last.file, _function(sources[last.file], last.line)) for last in sent}


def node_places(subject: Subject, traces: Sequence[ViolationTrace]) -> tuple[str, ...]:
    """What each node of a run did last: where it was, or what it had decided just before it came to wait."""
    files = {file.file: file for file in subject.report.code_under_test.map}
    made = []
    for node, stack in enumerate(traces[0].stood if traces else ()):
        if stack:
            file, line = _last_decision(traces[0], node, stack[0], files)
            made.append(f"{file}:{line} in {_function(functions(files[file].source), line)}")
    return tuple(made)


def _last_decision(
    trace: ViolationTrace, node: int, at: tuple[str, int], files: Mapping[str, MappedFile]
) -> tuple[str, int]:
    """The last decision that a node took in another function, just before it came to this statement."""
    mine = [each for each in trace.executed if each.node == node]
    here = next((each for each in mine if (each.file, each.line) == at), None)
    if here is None:
        return at
    around = _function(functions(files[at[0]].source), at[1])
    for each in mine:
        is_decision = _DECISION.match(_line(files[each.file].source, each.line)) is not None
        if is_decision and each.step < here.step and each.time_s == here.time_s:
            function = _function(functions(files[each.file].source), each.line)
            if (each.file, function) != (at[0], around):
                return each.file, each.line
    return at


def _function(all_functions: Sequence[Function], line: int) -> str:
    return next(function.name for function in all_functions if line in function)


def _line(source: str, number: int) -> str:
    lines = source.splitlines()
    return lines[number - 1].strip() if number <= len(lines) else ""
