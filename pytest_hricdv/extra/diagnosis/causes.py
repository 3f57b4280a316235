"""`diagnose`: groups the failures of a session by cause, confirms causes by experiments, and locates them in the code.

`DiagnosisFeature.extend_report` calls it after the last test. Each step has a module of its own: `grouping`,
`experiments`, `pair_search` for the deciding change, `switching` for branch decisions, and `locations`. `cause_of`
makes the `Cause` of a report from their results; `merging` calls it, too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import cast

import msgspec
from msgspec.structs import replace

from pytest_hricdv.extra.diagnosis.executed_lines import neighbour_runner
from pytest_hricdv.extra.diagnosis.experiments import Experiments, list_experiments
from pytest_hricdv.extra.diagnosis.failures import FAULT
from pytest_hricdv.extra.diagnosis.grouping import ExperimentEvidence, Group
from pytest_hricdv.extra.diagnosis.locations import locate, node_places, rank_places, traces_of, variation_coverage
from pytest_hricdv.extra.diagnosis.options import DiagnosisOptions
from pytest_hricdv.extra.diagnosis.pair_search import PairSearch, keep_run
from pytest_hricdv.extra.diagnosis.records import (
    CAUSES,
    DIAGNOSIS,
    Cause,
    Decision,
    Diagnosis,
    KindName,
)
from pytest_hricdv.extra.diagnosis.runs import Run, RunSummary, remember_runs, runner
from pytest_hricdv.extra.diagnosis.spectrum import Suspect
from pytest_hricdv.extra.diagnosis.subject import Subject
from pytest_hricdv.extra.diagnosis.switching import SwitchSearch, make_switch_runner
from pytest_hricdv.extra.diagnosis.trace import ViolationTrace
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.generate.rng import digest
from pytest_hricdv.report.formatting import plural
from pytest_hricdv.results.model import Report, TestResult
from pytest_hricdv.runtime.supervision import took_long
from pytest_hricdv.session.feature import FeatureSession

SWITCHED_TESTS = 2
"""Number of failing tests of a cause, if it has as many, that must pass with a decision reversed to count: a single
test may pass by chance."""


def switch_decisions(
    session: FeatureSession, subject: Subject, experiments: Experiments, decisions: PairSearch, groups: Sequence[Group]
) -> None:
    """Look for decisions of the code without which tests of each cause pass, while runs are left."""
    run = make_switch_runner(session.rerunner, session.context.code)
    groups = [group for group in groups if not group.is_known]
    for place, group in enumerate(groups):
        names = sorted({*group.nodeids} & experiments.tests.keys(), key=experiments.length)
        shrunk = decisions.minimal_of(group)
        names = [*shrunk, *(name for name in names if name not in shrunk)][:SWITCHED_TESTS]
        if not names:
            continue
        ranked = rank_places(subject, group, traces_of(experiments, group), variation_coverage(experiments, group))
        scores = {(suspect.file, suspect.line): suspect.score for suspect in ranked}
        search = SwitchSearch(run, (experiments.budget - experiments.used) // (len(groups) - place))
        tests = []
        for name in names:
            test = shrunk[name].test if name in shrunk else experiments.tests[name]
            wanted = {failure.requirement for failure in group.failures if failure.nodeid == name}
            tests.append((test, partial(_passes, wanted)))
        try:
            experiments.switched[group.first] = search.search(tests, scores)
        except KeyboardInterrupt:
            experiments.ended = "interrupted"
            return
        finally:
            experiments.used += search.used
        _compare(experiments, group, names, groups[:place])


def _passes(wanted: set[str], control: RunSummary, made: RunSummary) -> bool:
    """Whether a run passes what the control violates, and all that this passes: a robot that does nothing does not."""
    violated = wanted & {*control.violated}
    return bool(violated) and not made.violated and {*control.checked, *(violated - {FAULT})} <= {*made.checked}


def _compare(experiments: Experiments, group: Group, names: Sequence[str], before: Sequence[Group]) -> None:
    """Note that causes are one: the same decision, the most suspicious of each, lets the tests of both pass."""
    first = experiments.switched[group.first][:1]
    for other in before:
        if first and first == experiments.switched.get(other.first, [])[:1]:
            experiments.together.add((names[0], group.first[0], other.first[0]))


NAME = "diagnosis"
"""The name of this feature in journals."""

FOUND: msgspec.json.Decoder[tuple[tuple[Cause, ...], Diagnosis]] = msgspec.json.Decoder(
    tuple[tuple[Cause, ...], Diagnosis]
)
"""Reads what a journal keeps: the causes, and what they rest on."""

FIRST_TESTS = 2
"""Number of tests of each cause that are run without its disturbance before the deciding change is searched: a single
one may be an exception."""


def diagnose(session: FeatureSession, report: Report, options: DiagnosisOptions) -> Report:
    """The report with its causes, after experiments."""
    subject = Subject.of(report)
    if not subject.failures:
        return report
    budget = options.budget(len(subject.tests))
    failing = {failure.nodeid for failure in subject.failures}
    tell = session.wait(f"looking for the causes of {plural(len(failing), 'failing test')}")
    chosen = session.aggregation.chosen
    cases = {name: chosen[name] for name in sorted(failing) if name in chosen}
    if options.runs is None:  # where the code was is in the error, and fifty such runs take ten minutes
        cases = {
            name: case
            for name, case in cases.items()
            if not took_long((*subject.tests[name].errors, subject.tests[name].failure))
        }
    concrete = {name: case.concrete for name, case in cases.items()}
    run = runner(
        session.rerunner,
        session.context.code,
        {test.id: test for test in concrete.values()},
        session.context.measurement,
    )
    run = count_runs(remember_runs(run, session.aggregation.journaling, NAME), budget, tell)
    # The other half is for switches.
    experiments = Experiments(subject.groups, concrete, run, budget - budget // 2)
    spaces = {name: case.ranges for name, case in cases.items()}
    decisions = PairSearch(experiments, spaces, neighbour_runner(session.rerunner, session.context.code))
    groups = experiments.groups(enough=FIRST_TESTS)
    _keep(session, *_by_now(session, subject, experiments, decisions, groups))
    decisions.decide(groups)
    _keep_minimal(session, experiments, decisions)
    groups = experiments.groups()
    _trace(experiments, groups)
    experiments.budget = budget
    switch_decisions(session, subject, experiments, decisions, groups)
    groups = experiments.groups()
    session.interrupted |= experiments.ended == "interrupted"
    causes, basis = _by_now(session, subject, experiments, decisions, groups)
    _keep(session, causes, basis)
    return DIAGNOSIS.put(CAUSES.put(report, causes), basis)


def count_runs(run: Run, budget: int, tell: Callable[[str], None]) -> Run:
    """Runs a test, and tells how many were run."""
    runs = 0

    def run_and_tell(test: ConcreteTest) -> RunSummary | None:
        nonlocal runs
        runs += 1
        tell(f"run {runs} of at most {budget}")
        return run(test)

    return run_and_tell


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
                    traces_of(experiments, group),
                    variation_coverage(experiments, group),
                    experiments.switched.get(group.first, ()),
                ),
                experiments.switched.get(group.first, ()),
                traces_of(experiments, group),
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
    for (name, requirement), minimal in decisions.minimal.items():
        if experiments.ended == "interrupted":
            return
        try:
            experiments.used += 1
            decisions.replays[name, requirement] = keep_run(session.rerunner, chosen[name], name, minimal)
        except KeyboardInterrupt:
            experiments.ended = "interrupted"


def _with_minimal(cause: Cause, subject: Subject, group: Group, decisions: PairSearch) -> Cause:
    """The cause with its shrunk test, if one was shrunk and can be rerun."""
    kept = [
        (name, left, replay)
        for name, left in decisions.minimal_of(group).items()
        if (replay := decisions.replays.get((name, left.requirement))) is not None
    ]
    if not kept:
        return cause
    name, left, replay = kept[0]
    lines = in_order_begun([action.command for action in left.test.actions], left.ran.begun)
    return replace(cause, minimal=lines, minimal_of=subject.tests[name].id, is_shrunk=True, replay=replay)


def _keep(session: FeatureSession, causes: tuple[Cause, ...], basis: Diagnosis) -> None:
    """Keep them for a report that is rebuilt."""
    session.aggregation.journaling.keep(NAME, CAUSES.name, msgspec.json.encode((causes, basis)))


def _kinds(names: Mapping[str, type]) -> dict[str, KindName]:
    return {name: cast("KindName", kind.__name__) for name, kind in names.items()}


def _trace(experiments: Experiments, groups: Sequence[Group]) -> None:
    """Run, traced, a test of each cause of which no test was run unchanged, while runs are left."""
    for group in groups:
        names = sorted(experiments.tests.keys() & {*group.nodeids}, key=experiments.length)
        if names and not group.is_known and experiments.controls.keys().isdisjoint(names):
            if experiments.used >= experiments.budget or experiments.ended == "interrupted":
                return
            try:
                experiments.control(names[0])
            except KeyboardInterrupt:
                experiments.ended = "interrupted"


def cause_of(
    subject: Subject,
    group: Group,
    evidence: ExperimentEvidence,
    decision: Decision | None,
    ranked: Sequence[Suspect],
    switched: Sequence[tuple[str, int]] = (),
    traces: Sequence[ViolationTrace] = (),
) -> Cause:
    """The cause of a group of failures, for the report.

    Args:
        subject: the subject whose failures they are.
        group: the failures.
        evidence: the evidence of experiments.
        decision: what decides; None if nobody tried.
        ranked: statements of the code, the most suspicious first.
        switched: file and line of decisions with which tests of it pass, reversed.
        traces: the traces of runs that failed for it.
    """
    tests = sorted(
        (subject.tests[name] for name in group.nodeids),
        key=lambda test: (test.nodeid not in group.telling, len(test.abstract), test.id, test.nodeid),
    )
    _, state, _ = group.first
    confirmed = {
        failure.nodeid for failure in group.failures if (failure.nodeid, failure.requirement) in evidence.confirmed
    }
    shortest = next((test for test in tests if test.nodeid in confirmed & group.telling), tests[0])
    return Cause(
        id=id_of(group),
        requirements=group.requirements,
        tests=tuple(dict.fromkeys(test.id for test in tests)),
        change=group.change,
        state=state,
        minimal=_as_begun(shortest),
        minimal_of=shortest.id,
        replay=shortest.replay,
        locations=locate(subject, ranked, switched, is_compared=subject.compares(group)),
        stood=node_places(subject, traces),
        schedule=shortest.concrete.schedule,
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
