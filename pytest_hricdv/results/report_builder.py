"""The report of a session: `build_result` makes the result of a test, `assemble` the report of all, at the end.

`TestRunner` calls the first in the process of a test. In the controlling process, `declare_report` makes the report
before the first result, and `SessionReporter` assembles it; `rebuild` makes it from the journal of a session that died.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypedDict
from zlib import decompress  # as now: the code under test may replace it

from msgspec.structs import replace

from pytest_hricdv._base.input_file import from_json
from pytest_hricdv.coverage.code_map import CodeMap, CoverageError
from pytest_hricdv.coverage.reachability import Reachability
from pytest_hricdv.coverage.records import ReportedCode
from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.execution.hri_case import HriCase
from pytest_hricdv.execution.outcome import TestOutcome
from pytest_hricdv.generate import chosen_values
from pytest_hricdv.generate.actors import after_to_data
from pytest_hricdv.generate.schedule import schedule_to_data
from pytest_hricdv.generate.suite import Suite, diagnose
from pytest_hricdv.monitor import Criterion, Requirement, RequirementResult
from pytest_hricdv.monitor.analysis import limits, names_shown
from pytest_hricdv.results.codec import check_report
from pytest_hricdv.results.derivation import NO_CLOSURE, declare_suite, derive
from pytest_hricdv.results.gates import Exemption
from pytest_hricdv.results.journal import Journal
from pytest_hricdv.results.model import (
    SCHEMA,
    ActionParameters,
    ConcreteParameters,
    GatePolicy,
    ModelSource,
    NcExemption,
    Report,
    RequirementLimit,
    RequirementText,
    RerunOptions,
    SuiteResult,
    TestResult,
)
from pytest_hricdv.results.origin import Diversity, GenerationResult, LastNewPlan
from pytest_hricdv.results.timeline import timeline
from pytest_hricdv.testbench import Testbench


class PytestOutcome(TypedDict):
    """The outcome of a test in pytest: how it ended, its duration (s), and the text of its failure."""

    outcome: TestOutcome
    wall_s: float
    failure: str


NOT_RUN = PytestOutcome(outcome="not-run", wall_s=0.0, failure="")


def build_result(
    case: HriCase,
    nodeid: str,
    result: CaseResult | None,
    *,
    code: CodeMap | None = None,
    requirements: Sequence[Criterion],
    unmeasured: str = "",
    ending: PytestOutcome = NOT_RUN,
) -> TestResult:
    """The result of a test.

    Args:
        result: the result of its run; None if it was not run, or did not end: then nothing is checked or covered.
        code: the code under test; None if it is not measured.
        unmeasured: why the run was not measured.
        ending: what pytest says of the test.
    """
    test = case.abstract
    actions = (ActionParameters(command=a.command, parameters=dict(a.parameters)) for a in case.concrete.actions)
    outcome = result and result.outcome
    return TestResult(
        nodeid=nodeid,
        suite=case.suite,
        id=test.id,
        target=test.target,
        name=test.name,
        beliefs=test.beliefs,
        abstract=test.lines,
        values=chosen_values.to_data(test.values),
        concrete=ConcreteParameters(
            actions=tuple(actions),
            run=dict(case.concrete.run),
            schedule=schedule_to_data(case.concrete.schedule),
        ),
        seed=test.seed,
        plans=dict(test.plans) if result else {},
        sim_s=result.sim_s if result else 0.0,
        skipped_s=outcome.skipped_s if outcome else 0.0,
        fidelity=outcome.fidelity if outcome else "",
        engine=result.engine if result else "",
        end_reason=outcome.ended if outcome else "",
        outcomes=tuple(outcome.outcomes) if outcome else (),
        requirements=_requirements(result, requirements),
        code=result.code.share(code.statements) if result and result.code and code else None,
        timeline=timeline(result.record, result.verdicts, result.sim_s) if result else None,
        unmeasured=unmeasured,
        action_times_s=tuple(round(time_s, 3) for time_s in result.action_times_s) if result else None,
        bystander_events=tuple((round(time_s, 3), act) for time_s, act in result.bystander_events) if result else (),
        action_indices=tuple(number + 1 for number in result.begun) if result and case.concrete.actors else None,
        after={number: tuple(causes) for number, causes in after_to_data(test.after).items()},
        cross={name: tuple(map(tuple, hits)) for name, hits in result.cross.items()} if result else None,
        record_sha256=result.record.sha256 if result else None,
        errors=result.errors if result else (),
        **ending,
    )


def _requirements(result: CaseResult | None, requirements: Sequence[Criterion]) -> dict[str, RequirementResult]:
    if result is None:
        return {requirement.id: UNCHECKED for requirement in requirements}
    return {verdict.requirement: verdict.result for verdict in result.verdicts}


UNCHECKED = RequirementResult(
    verdict="NC", triggers=0, passes=0, failures=0, untriggered=0, pending=0, violations=(), margin=None
)
"""The result of a test without a run."""


@dataclass(frozen=True)
class GeneratedSuite:
    """A suite, how long generating it took (s; 0 if `cached`), and keys that its generator adds to the report."""

    suite: Suite
    wall_s: float
    cached: bool
    sections: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class SessionInfo:
    """The content of a report besides test results; `unmeasured` is why no code was measured."""

    testbench: Testbench
    requirements: tuple[Criterion, ...]
    suites: tuple[GeneratedSuite, ...]
    code: CodeMap
    unmeasured: str
    known_violations: Mapping[str, Exemption]
    allowed_untriggered: Mapping[str, Exemption]
    until: Mapping[str, str]
    strict: bool
    version: str
    workers: int
    rerun: RerunOptions
    models: Mapping[str, ModelSource]
    reachability: Reachability
    sizes: Mapping[str, int]
    """Suite -> its tests, selected or not."""
    shard: str = ""
    policy: GatePolicy | None = None
    environment: Mapping[str, str] = field(default_factory=dict)


def requirement_texts(requirements: Sequence[Criterion]) -> dict[str, RequirementText]:
    """Requirement -> its texts for people."""
    return {criterion.id: _requirement_text(criterion) for criterion in requirements}


def _requirement_text(criterion: Criterion) -> RequirementText:
    """Its texts for people, and the names and limits in its formula, which the page of a test draws."""
    text = RequirementText(title=criterion.title, source=criterion.source, text=criterion.text, group=criterion.group)
    if not isinstance(criterion, Requirement):
        return text
    drawn = (
        RequirementLimit(name=limit.name, relation=limit.relation, value=limit.value)
        for limit in limits(criterion.formula)
    )
    reads = dict.fromkeys((*names_shown(criterion.formula), *criterion.shows))
    return replace(text, reads=tuple(reads), limits=tuple(drawn), **_acceptance(criterion))


def _acceptance(requirement: Requirement) -> dict[str, str]:
    """The evidence of a suggested requirement, and who accepted it and when."""
    by = (requirement.accepted_by, f"on {requirement.accepted_on}" if requirement.accepted_on else "")
    return {"suggested": requirement.suggested, "accepted": " ".join(filter(None, by))}


def declare_report(session: SessionInfo, chosen: Mapping[str, HriCase]) -> Report:
    """The report of a session before its first result, with all selected tests (node id -> test)."""
    code, testbench = session.code, session.testbench
    report = Report(
        schema=SCHEMA,
        version=session.version,
        testbench=testbench.name,
        selected=0,
        reported=0,
        not_run=0,
        not_run_tests=(),
        wall_s=0.0,
        workers=session.workers,
        known_violations={name: exemption.reason for name, exemption in session.known_violations.items()},
        allowed_untriggered={
            name: NcExemption(reason=exemption.reason, suites=exemption.suites, until=str(exemption.until or ""))
            for name, exemption in session.allowed_untriggered.items()
        },
        known_when={
            name: exemption.condition for name, exemption in session.known_violations.items() if exemption.condition
        },
        known_until=dict(session.until),
        strict=session.strict,
        shard=session.shard,
        policy=session.policy,
        environment=dict(session.environment),
        rerun_options=session.rerun,
        requirements=requirement_texts(session.requirements),
        units=dict(testbench.units),
        sampled_while=dict(testbench.sampling_conditions),
        outcome_label=testbench.outcome_label,
        state=testbench.simulation.film.state if testbench.simulation.film else "",
        code_under_test=ReportedCode(
            packages=tuple(testbench.code),
            sha256=code.sha256,
            waivers=code.waivers,
            map=code.records,
            measured=False,
            reason=code.nothing or session.unmeasured,
            files=(),
            unmeasured_files=code.unmeasured,
        ),
        models=session.models,
        cross_products=session.reachability.products,
        exploration=session.reachability.exploration,
        suites=tuple(_suite(made, session.sizes[made.suite.name], session.models) for made in session.suites),
        closure=NO_CLOSURE,
        tests=tuple(build_result(case, nodeid, None, requirements=()) for nodeid, case in sorted(chosen.items())),
    )
    return replace(report, **{key: value for suite in session.suites for key, value in suite.sections.items()})


def _suite(generated: GeneratedSuite, size: int, models: Mapping[str, ModelSource]) -> SuiteResult:
    generation = generated.suite.generation
    return declare_suite(
        name=generated.suite.name,
        seed=generated.suite.seed,
        size=size,
        generation=GenerationResult(
            wall_s=round(generated.wall_s, 3),
            cached=generated.cached,
            bdi_runs=generation.bdi_runs,
            iterations=generation.iterations,
            converged_at=generation.converged_at,
            q_delta=generation.q_delta,
            distinct_texts=generation.distinct_texts,
            reward=generation.reward,
            diagnosis=_diversity(generated.suite),
            notes=generation.notes,
        ),
        plans=_list_plans(generated.suite, models),
    )


def _diversity(suite: Suite) -> Diversity:
    diagnosis = diagnose(suite)
    return Diversity(
        distinct_subsets=diagnosis.distinct_subsets,
        belief_entropy_bits=diagnosis.belief_entropy_bits,
        belief_entropy_most_bits=diagnosis.belief_entropy_most_bits,
        plans_executed={agent: len(labels) for agent, labels in diagnosis.plans.items()},
        last_new_plan=LastNewPlan(iteration=suite.generation.last_new_plan_at, test=diagnosis.last_new_plan_at),
    )


def _list_plans(suite: Suite, models: Mapping[str, ModelSource]) -> dict[str, tuple[str, ...]]:
    """The plans to cover. Tests that a model generated and that were read from a file are still compared with it."""
    if suite.generation.declared_plans or not any(test.plans for test in suite.tests):
        return {agent: tuple(labels) for agent, labels in suite.generation.declared_plans.items()}
    return {agent: tuple(model.plans) for agent, model in models.items()}


def assemble(
    declared: Report, results: Sequence[TestResult], reasons: Mapping[str, str], wall_s: float
) -> tuple[Report, str]:
    """The report of a session, and what is wrong with it: if a waived statement ran, it has no code coverage.

    Args:
        declared: the report of `declare_report`.
        results: the results of the tests that were reported.
        reasons: node id -> why it has no result, where known.
        wall_s: duration of the session.
    """
    reported = {result.nodeid for result in results}
    not_run = (
        replace(test, failure=reasons.get(test.nodeid, "")) for test in declared.tests if test.nodeid not in reported
    )
    code = declared.code_under_test
    unmeasured = min((result.unmeasured for result in results if result.unmeasured), default=code.reason)
    report = replace(
        declared,
        wall_s=round(wall_s, 3),
        code_under_test=replace(code, reason=unmeasured),
        tests=(*results, *not_run),
    )
    try:
        return derive(report), ""
    except CoverageError as error:
        nothing = ReportedCode(
            packages=code.packages, sha256="", waivers=(), map=(), measured=False, reason=str(error), files=()
        )
        return derive(replace(report, code_under_test=nothing)), str(error)


def rebuild(journal: Journal) -> tuple[Report, str]:
    """The report of what a journal has, and what is wrong with it; see `assemble`.

    Raises:
        ValueError: no test had begun, another version wrote it, or the parts contradict each other.
    """
    declared, results = content(journal)
    return assemble(declared, results, journal.reasons, journal.wall_s)


def content(journal: Journal) -> tuple[Report, list[TestResult]]:
    """The report without results, and the results, of an untrusted journal. Raises the same errors as `rebuild`."""
    if journal.declared is None:
        raise ValueError("no test had begun")
    declared = from_json(str(journal.declared, "utf-8"), Report)
    results = [from_json(str(decompress(packed), "utf-8"), TestResult) for packed in journal.results.values()]
    check_report(replace(declared, tests=tuple(results)))
    return declared, results
