"""Diagnosing: from a report with failing tests to the causes of its failures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import cast

import msgspec
from msgspec.structs import replace

from pytest_hricdv.coverage.code_map import Bits, CodeMap
from pytest_hricdv.coverage.gaps import Function, functions
from pytest_hricdv.extra.diagnosis.executed_lines import neighbour_runner
from pytest_hricdv.extra.diagnosis.experiments import Experiments, list_experiments
from pytest_hricdv.extra.diagnosis.failures import FAULT, Failure, failures_of
from pytest_hricdv.extra.diagnosis.grouping import ExperimentEvidence, Group, group_failures
from pytest_hricdv.extra.diagnosis.interventions import Intervention, SwitchSearch, intervene
from pytest_hricdv.extra.diagnosis.options import DiagnosisOptions
from pytest_hricdv.extra.diagnosis.pair_search import PairSearch, keep_run
from pytest_hricdv.extra.diagnosis.places import LEAST, weight_suspects
from pytest_hricdv.extra.diagnosis.records import (
    CAUSES,
    DIAGNOSIS,
    Cause,
    Decision,
    Diagnosis,
    KindName,
    SuspiciousPlace,
)
from pytest_hricdv.extra.diagnosis.runs import RunSummary, remember_runs, runner
from pytest_hricdv.extra.diagnosis.spectrum import Spectra, Suspect, combine
from pytest_hricdv.extra.diagnosis.trace import ViolationTrace
from pytest_hricdv.generate.abstract import disturbance_of
from pytest_hricdv.generate.rng import digest
from pytest_hricdv.report.formatting import plural
from pytest_hricdv.results.model import Report, TestResult
from pytest_hricdv.session.feature import FeatureSession

NAME = "diagnosis"
"""Of this part, in journals."""

FOUND: msgspec.json.Decoder[tuple[tuple[Cause, ...], Diagnosis]] = msgspec.json.Decoder(
    tuple[tuple[Cause, ...], Diagnosis]
)
"""Reads what a journal keeps: the causes, and what they rest on."""

MAX_PLACES = 5
"""So many of the most suspicious statements are shown."""

INTERVENTIONS = 0.5
"""This share of the runs is kept for interventions in the code; chosen."""

FIRST_TESTS = 2
"""So many tests of each cause are run without its disturbance before it is looked for what decides: one may be odd."""


@dataclass(frozen=True)
class Subject:
    """What a diagnosis is about: a report's tests and their failures."""

    report: Report
    tests: Mapping[str, TestResult]
    failures: tuple[Failure, ...]
    spectra: Spectra

    @classmethod
    def of(cls, report: Report) -> Subject:
        """All that a report tells."""
        tests = {test.nodeid: test for test in report.tests if test.timeline is not None}
        declared = {} if report.strict else report.known_violations
        failures = tuple(failure for test in tests.values() for failure in failures_of(test, report.state, declared))
        bits = {name: measured for name, test in tests.items() if (measured := Bits.of(test.code)) is not None}
        return cls(report, tests, failures, Spectra(CodeMap.of(report.code_under_test), bits))

    def groups(self, evidence: ExperimentEvidence) -> tuple[Group, ...]:
        """Failures that have probably one cause."""
        disturbances = {name: _disturbances(test) for name, test in self.tests.items()}
        return group_failures(disturbances, self.failures, self.spectra, evidence)

    def find_violators(self, group: Group) -> set[str]:
        """Node ids of tests that violate the same requirements, for this cause or another: none of them has passed."""
        return {failure.nodeid for failure in self.failures if failure.requirement in group.requirements}

    def compares(self, group: Group) -> bool:
        """Whether the code was measured in a run that fails for the cause, and in one that passes."""
        measured = self.spectra.bits.keys()
        return not measured.isdisjoint(group.nodeids) and bool(measured - {*group.nodeids} - self.find_violators(group))


def _disturbances(test: TestResult) -> tuple[str, ...]:
    return tuple(dict.fromkeys(name for line in test.abstract if (name := disturbance_of(line)) is not None))


def diagnose(session: FeatureSession, report: Report, options: DiagnosisOptions) -> Report:
    """The report with its causes, after experiments."""
    subject = Subject.of(report)
    if not subject.failures:
        return report
    budget = options.budget(len(subject.tests))
    failing = {failure.nodeid for failure in subject.failures}
    limit = f"in at most {plural(budget, 'run')}"
    session.say("")
    session.say(f"hricdv: looking for the causes of {plural(len(failing), 'failing test')}, {limit} ...")
    chosen = session.aggregation.chosen
    cases = {name: chosen[name] for name in sorted(failing) if name in chosen}
    concrete = {name: case.concrete for name, case in cases.items()}
    run = runner(
        session.rerunner,
        session.context.code,
        {test.id: test for test in concrete.values()},
        session.context.measurement,
    )
    run = remember_runs(run, session.aggregation.journaling, NAME)
    experiments = Experiments(subject.groups, concrete, run, budget - int(INTERVENTIONS * budget))
    spaces = {name: case.ranges for name, case in cases.items()}
    decisions = PairSearch(experiments, spaces, neighbour_runner(session.rerunner, session.context.code))
    groups = experiments.groups(enough=FIRST_TESTS)
    _keep(session, *_by_now(session, subject, experiments, decisions, groups))
    decisions.decide(groups)
    _keep_minimal(session, experiments, decisions)
    groups = experiments.groups()
    _trace(experiments, groups)
    experiments.budget = budget
    _switch(session, subject, experiments, decisions, groups)
    groups = experiments.groups()
    session.interrupted |= experiments.ended == "interrupted"
    causes, basis = _by_now(session, subject, experiments, decisions, groups)
    _keep(session, causes, basis)
    return DIAGNOSIS.put(CAUSES.put(report, causes), basis)


def _by_now(
    session: FeatureSession,
    subject: Subject,
    experiments: Experiments,
    decisions: PairSearch,
    groups: Sequence[Group],
) -> tuple[tuple[Cause, ...], Diagnosis]:
    """The causes by now, and what they rest on."""
    made = tuple(
        _with_minimal(
            cause_of(
                subject,
                group,
                experiments.evidence,
                decisions.of(group),
                rank_places(
                    subject,
                    group,
                    _traces(experiments, group),
                    _varied(experiments, group),
                    experiments.switched.get(group.first, ()),
                ),
                experiments.switched.get(group.first, ()),
                _traces(experiments, group),
            ),
            subject,
            group,
            decisions,
        )
        for group in groups
    )
    vocabulary = session.context.run_settings.testbench.vocabulary()
    basis = Diagnosis(
        runs=experiments.used,
        budget=experiments.budget,
        end_reason=experiments.ended,
        experiments=list_experiments(experiments.evidence),
        signals=_kinds(vocabulary.signals),
        messages={topic: _kinds(fields) for topic, fields in vocabulary.messages.items()},
    )
    return made, basis


def _keep_minimal(session: FeatureSession, experiments: Experiments, decisions: PairSearch) -> None:
    """Write replay files of tests that were shrunk."""
    chosen = session.aggregation.chosen
    for name, minimal in decisions.minimal.items():
        if experiments.ended == "interrupted":
            return
        try:
            experiments.used += 1
            decisions.replays[name] = keep_run(session.rerunner, chosen[name], name, minimal)
        except KeyboardInterrupt:
            experiments.ended = "interrupted"


def _with_minimal(cause: Cause, subject: Subject, group: Group, decisions: PairSearch) -> Cause:
    """The cause with what is left of a test of it, where one was shrunk and can be run again."""
    name = decisions.minimal_of(group)
    if name is None or (replay := decisions.replays.get(name)) is None:
        return cause
    left = decisions.minimal[name]
    lines = in_order_begun([action.command for action in left.test.actions], left.ran.begun)
    return replace(cause, minimal=lines, minimal_of=subject.tests[name].id, is_shrunk=True, replay=replay)


def _keep(session: FeatureSession, causes: tuple[Cause, ...], basis: Diagnosis) -> None:
    """So that a report that is rebuilt has them."""
    session.aggregation.journaling.keep(NAME, CAUSES.name, msgspec.json.encode((causes, basis)))


def _kinds(names: Mapping[str, type]) -> dict[str, KindName]:
    return {name: cast("KindName", kind.__name__) for name, kind in names.items()}


def _trace(experiments: Experiments, groups: Sequence[Group]) -> None:
    """Run a test of each cause of which none was run as it was, while runs are left: such runs are traced."""
    for group in groups:
        names = sorted(experiments.tests.keys() & {*group.nodeids}, key=experiments.length)
        if names and not group.is_known and experiments.controls.keys().isdisjoint(names):
            if experiments.used >= experiments.budget or experiments.ended == "interrupted":
                return
            try:
                experiments.control(names[0])
            except KeyboardInterrupt:
                experiments.ended = "interrupted"


def _switch(
    session: FeatureSession, subject: Subject, experiments: Experiments, decisions: PairSearch, groups: Sequence[Group]
) -> None:
    """Look for decisions of the code without which tests of each cause pass, while runs are left."""
    run = intervene(session.rerunner, session.context.code)
    groups = [group for group in groups if not group.is_known]
    for place, group in enumerate(groups):
        name = decisions.minimal_of(group) or decisions.shortest(group)
        if name is None or experiments.ended == "interrupted":
            continue
        test = decisions.minimal[name].test if name in decisions.minimal else experiments.tests[name]
        ranked = rank_places(subject, group, _traces(experiments, group), _varied(experiments, group))
        scores = {(suspect.file, suspect.line): suspect.score for suspect in ranked}
        wanted = {failure.requirement for failure in group.failures if failure.nodeid == name}
        left = experiments.budget - experiments.used
        search = SwitchSearch(run, left // (len(groups) - place))

        def passes(control: RunSummary, made: RunSummary, wanted: set[str] = wanted) -> bool:
            lasting = {*control.checked, *(wanted & {*control.violated} - {FAULT})}
            return bool(wanted & {*control.violated}) and not made.violated and lasting <= {*made.checked}

        try:
            experiments.switched[group.first] = search.search(test, scores, passes)
        except KeyboardInterrupt:
            experiments.ended = "interrupted"
        experiments.used += search.used
        _compare(experiments, group, name, groups[:place])


def _compare(experiments: Experiments, group: Group, name: str, before: Sequence[Group]) -> None:
    """Note that causes are one: the same intervention lets tests of both pass, of all that do the most suspicious."""
    first = next(iter(experiments.switched.get(group.first, ())), None)
    for other in before:
        same = next(iter(experiments.switched.get(other.first, ())), None)
        if first is not None and same is not None and (same.file, same.line) == (first.file, first.line):
            experiments.together.add((name, group.first[0], other.first[0]))


def _traces(experiments: Experiments, group: Group) -> list[ViolationTrace]:
    """Of runs that failed for a cause, up to what failed first; of what is known only where nothing else failed."""
    first: dict[str, Failure] = {}
    for failure in sorted(group.failures, key=lambda failure: failure.is_known):
        first.setdefault(failure.nodeid, failure)
    runs = ((failure.requirement, experiments.controls.get(name)) for name, failure in first.items())
    return [run.traces[requirement] for requirement, run in runs if run is not None and requirement in run.traces]


def cause_of(
    subject: Subject,
    group: Group,
    evidence: ExperimentEvidence,
    decision: Decision | None,
    ranked: Sequence[Suspect],
    switched: Sequence[Intervention] = (),
    traces: Sequence[ViolationTrace] = (),
) -> Cause:
    """What a report says of a group of failures.

    Args:
        subject: what the failures are of.
        group: the failures.
        evidence: of experiments.
        decision: what decides; None where nobody tried.
        ranked: statements of the code, the most suspicious first.
        switched: interventions with which a test of it passes.
        traces: of runs that failed for it.
    """
    tests = sorted(
        (subject.tests[name] for name in group.nodeids), key=lambda test: (len(test.abstract), test.id, test.nodeid)
    )
    _, state, _ = group.first
    confirmed = {
        failure.nodeid for failure in group.failures if (failure.nodeid, failure.requirement) in evidence.confirmed
    }
    shortest = next((test for test in tests if test.nodeid in confirmed), tests[0])
    return Cause(
        id=id_of(group),
        requirements=group.requirements,
        tests=tuple(dict.fromkeys(test.id for test in tests)),
        change=group.change,
        state=state,
        minimal=_as_begun(shortest),
        minimal_of=shortest.id,
        replay=shortest.replay,
        locations=_places(subject, ranked, switched, is_compared=subject.compares(group)),
        stood=_stood(subject, traces),
        deciding_change=_decides(group, len(confirmed), decision),
        minimal_pair=decision,
        confirmed=len(confirmed),
        is_known=group.is_known,
    )


def id_of(group: Group) -> str:
    """The id of a cause, by its failures: the same in each session."""
    requirement, state, said = group.first
    return digest("cause", group.change, requirement, state, *([said] if said else []))[:8]


def _as_begun(test: TestResult) -> tuple[str, ...]:
    """The lines of a test; of several actors as they began, so that they tell who did what in which order."""
    return test.abstract if test.action_indices is None else in_order_begun(test.abstract, test.action_starts)


def in_order_begun(lines: Sequence[str], begun: Iterable[tuple[float, int]]) -> tuple[str, ...]:
    """Lines as they began, then those that never did.

    Args:
        lines: of a test.
        begun: when (s), and the number of the line from 0, in the order in which they began.
    """
    numbers = [number for _, number in begun]
    left = [number for number in range(len(lines)) if number not in numbers]
    return tuple(lines[number] for number in (*numbers, *left))


def _decides(group: Group, confirmed: int, decision: Decision | None) -> str:
    decided = "" if decision is None else f"passes {decision.words}" if decision.kind else decision.words
    if not group.change:
        return decided
    if not confirmed:
        return decided or f"comes with the disturbance {group.change}; no run has confirmed it"
    tests = plural(len(group.nodeids), "test")
    # A test that was shrunk may have come to fail without the disturbance, for another cause: the others have not.
    is_same = decision is not None and decision.kind == "disturbance"
    decided = decided if is_same else f"passes without the disturbance {group.change}"
    return f"{decided}: {confirmed} of {tests} {'was' if confirmed == 1 else 'were'} run without it"


def _varied(experiments: Experiments, group: Group) -> list[tuple[Bits, bool]]:
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
    switched: Sequence[Intervention] = (),
) -> list[Suspect]:
    """The statements of the code, those first in which a cause is probably.

    Args:
        subject: what the failures are of.
        group: that have the cause.
        traces: of runs that failed for it, up to what failed first.
        varied: what runs of variations of its tests executed, and whether they failed for it.
        switched: interventions with which a test of it passes.
    """
    code = subject.spectra.code
    suspects = subject.spectra.suspects(group.nodeids, subject.find_violators(group))
    if {fails for _, fails in varied} == {True, False}:
        spectra = Spectra(code, {str(number): bits for number, (bits, _) in enumerate(varied)})
        failing = [str(number) for number, (_, fails) in enumerate(varied) if fails]
        suspects = combine(suspects, spectra, failing)
    shown = {(intervention.file, intervention.line) for intervention in switched}
    return weight_suspects(suspects, traces, () if code is None else code.files, shown)


def _places(
    subject: Subject, ranked: Sequence[Suspect], switched: Sequence[Intervention], *, is_compared: bool
) -> tuple[SuspiciousPlace, ...]:
    sources = {file.file: file.source for file in subject.report.code_under_test.map}
    shown = {(intervention.file, intervention.line): intervention.words for intervention in switched}
    return tuple(
        SuspiciousPlace(
            file=suspect.file,
            line=suspect.line,
            function=_function(functions(sources[suspect.file]), suspect.line),
            score=round(suspect.score, 4),
            likely=(suspect.file, suspect.line) in shown if shown else is_compared and round(suspect.score, 4) >= LEAST,
            experiment=shown.get((suspect.file, suspect.line), ""),
            text=_line(sources[suspect.file], suspect.line),
        )
        for suspect in ranked[:MAX_PLACES]
    )


def _stood(subject: Subject, traces: Sequence[ViolationTrace]) -> tuple[str, ...]:
    """Where the nodes of a run were, the innermost statement of each."""
    sources = {file.file: file.source for file in subject.report.code_under_test.map}
    stood = (stack[0] for trace in traces[:1] for stack in trace.stood if stack)
    return tuple(f"{file}:{line} in {_function(functions(sources[file]), line)}" for file, line in stood)


def _function(all_functions: Sequence[Function], line: int) -> str:
    return next(function.name for function in all_functions if line in function)


def _line(source: str, number: int) -> str:
    lines = source.splitlines()
    return lines[number - 1].strip() if number <= len(lines) else ""
