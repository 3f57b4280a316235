"""The result of a test, and the report of a session, as typed records: their types are the contract of `report.json`.

The records are msgspec structs, whose decoder checks every value and locates mistakes (`$.tests[3].outcome`). A field
without a default is always written and required; a field with a default is left out while it has it, so keys that only
some reports have stay absent. Sequences are tuples and mappings are read-only by type, so records can be shared.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, ClassVar, Final, Literal

from msgspec import Meta

from pytest_hricdv._base.record import Count, Names, NotNegative, Number, Percent, PlainRecord, ReplayName, TestId
from pytest_hricdv._base.schedule_record import ScheduleData
from pytest_hricdv.coverage.cross_product import CrossCoverage, ExplorationRecord, ProductDeclaration
from pytest_hricdv.coverage.records import (
    Closure,
    CodeShare,
    CurvePoint,
    PlanCoverage,
    ReportedCode,
    RequirementTally,
    SuiteCode,
)
from pytest_hricdv.execution.outcome import FAILING, TestOutcome
from pytest_hricdv.monitor import RequirementResult
from pytest_hricdv.results.behaviour import BehaviourChanges, Difference
from pytest_hricdv.results.behaviour import Timeline as Timeline
from pytest_hricdv.results.origin import GenerationResult, ReportOrigin, RerunOption
from pytest_hricdv.results.section import extend_record, further_engines, report_sections, test_sections

SCHEMA: Final = "hricdv-report/3"
SuiteName = Annotated[str, Meta(pattern=r"^[A-Za-z0-9_-]{1,100}\Z")]
"""Files are named after suites."""
Shard = Annotated[str, Meta(pattern=r"^([1-9]\d{0,3}/[1-9]\d{0,3})?\Z")]
"""The shard of a suite that was run, such as 2/3; at most `gates.MAX_SHARDS` shards; empty for the whole suite."""


class ActionParameters(PlainRecord, frozen=True, kw_only=True):
    """An action of the human with its sampled parameters."""

    command: str
    parameters: Mapping[str, Number]


class ConcreteParameters(PlainRecord, frozen=True, kw_only=True):
    """All sampled parameters of a test: of its actions, and of the whole run; and its schedule, where it has one."""

    actions: tuple[ActionParameters, ...]
    run: Mapping[str, Number]
    schedule: ScheduleData | None = None


class ReplayComparison(PlainRecord, frozen=True, kw_only=True):
    """How the run of a replayed test compares with the recorded one.

    Args:
        changed: what it depends on and is not as it was.
        hash_seed: how the seed of Python's hashes differs, as `0, now random`; the run need not depend on it.
    """

    file: str
    expected_sha256: str | None
    same: bool
    changed: Names
    hash_seed: str = ""


class TestResult(PlainRecord, frozen=True, kw_only=True):
    """One test and its result.

    Args:
        target: what generation aimed at.
        name: what a person calls it; may be empty.
        abstract: the abstract test, an action a line.
        skipped_s: simulated time without physics steps (s).
        end_reason: why the run ended, in the testbench's words.
        outcomes: how each interaction ended, in order.
        requirements: requirement -> verdict; empty if the test was not run: that is not NC.
        failure: the text of the failure, or why the test was not run.
        errors: what is wrong with the run besides its requirements, a sentence each; they fail the test.
        unmeasured: why the code was not measured, or not completely.
        timeline: None if no run came to an end, as are `action_times_s`, `cross` and `record_sha256`.
        action_times_s: when actions began (s), ascending; shorter than `abstract` where the run was over before.
        action_indices: of a test with several actors, which actions began at these times, as indices from 1; None
            where there is one actor: they begin in the order of `abstract`.
        bystander_events: what bystanders began, and when (s), as `[4.0, "dog: walk"]`.
        after: in a test with several actors, number of an action (from 1) -> those that have to be done before.
        cross: cross product -> the bins that the run hit, one for each hit.
        replay: what to give to `--hri-replay` to run this test again.
        values: parameters that were chosen instead of drawn: number of the command (from 1), or `run` -> parameter ->
            value.
        engine: the physics engine; empty if the testbench has none.
        repeats: in a merged report, the runs that differ from this one, which is the worst.
    """

    __test__: ClassVar[bool] = False

    nodeid: str
    suite: SuiteName
    id: TestId
    target: str
    name: str
    beliefs: Names
    abstract: Names
    concrete: ConcreteParameters
    seed: int
    plans: Mapping[str, Names]
    outcome: TestOutcome
    wall_s: NotNegative | None
    sim_s: NotNegative
    skipped_s: NotNegative
    fidelity: str
    engine: str = ""
    end_reason: str
    outcomes: Names
    requirements: Mapping[str, RequirementResult]
    code: CodeShare | None
    timeline: Timeline | None
    failure: str
    unmeasured: str
    action_times_s: tuple[NotNegative, ...] | None = None
    action_indices: tuple[Count, ...] | None = None
    after: Mapping[str, tuple[int, ...]] = {}
    bystander_events: tuple[tuple[NotNegative, str], ...] = ()
    cross: Mapping[str, tuple[Names, ...]] | None = None
    record_sha256: str | None = None
    errors: Names = ()
    replay: ReplayName | None = None
    replayed: ReplayComparison | None = None
    values: Mapping[str, Mapping[str, float]] = {}
    repeats: tuple[TestResult, ...] = ()

    @property
    def action_starts(self) -> tuple[tuple[float, int], ...]:
        """When actions began (s), ascending, and which, by their numbers from 0."""
        times = self.action_times_s or ()
        numbers = range(len(times)) if self.action_indices is None else [number - 1 for number in self.action_indices]
        return tuple(zip(times, numbers, strict=True))

    def violates(self, requirement: str) -> bool:
        """Whether its run violated a requirement."""
        return requirement in self.requirements and self.requirements[requirement].verdict == "Failed"

    @property
    def went_wrong(self) -> bool:
        """Whether its run violated a requirement, or had a fault."""
        return bool(self.errors) or any(map(self.violates, self.requirements))

    @property
    def fails(self) -> bool:
        """Whether it fails a session, a merge, a campaign."""
        return self.outcome in FAILING

    @property
    def leaves_evidence(self) -> bool:
        """Whether it leaves a file to replay and, where asked for, a film and a trace.

        A run that passed does not, where all that ended its test is an xfail of its author.
        """
        if self.outcome in ("passed", "not-run"):
            return False
        return self.outcome != "expected-failure" or self.went_wrong

    @property
    def engines(self) -> Names:
        """The physics engines that it ran on."""
        return tuple(name for name in (self.engine, *further_engines(self)) if name)

    @property
    def runs(self) -> tuple[TestResult, ...]:
        """All runs of the test: one, except in a merged report with runs that differ."""
        return (self, *self.repeats)


class SuiteResult(PlainRecord, frozen=True, kw_only=True):
    """A suite and what its tests covered. `size` counts its tests, selected or not; `tests` the selected ones."""

    name: SuiteName
    seed: int
    size: Count
    generation: GenerationResult
    tests: Count
    fidelity: str
    engine: str = ""
    requirements: Mapping[str, RequirementTally]
    code: SuiteCode
    plans: Mapping[str, PlanCoverage]
    cross: CrossCoverage
    curve: tuple[CurvePoint, ...]
    closure: Closure


class RequirementLimit(PlainRecord, frozen=True, kw_only=True):
    """A number in a requirement's formula that a signal, or `topic.field`, is compared with, in the unit of that."""

    name: str
    relation: Literal["<", "<=", ">", ">=", "==", "!="]
    value: Number


class RequirementText(PlainRecord, frozen=True, kw_only=True):
    """A requirement for people: title, source (a standard, a paper), and the formula that the monitor checks.

    Args:
        group: what it belongs to; empty where nothing was said.
        reads: signals, `topic.field` and topics in its formula, and what a violation shows beside; empty if it has
            no formula, and in reports of older versions.
        limits: the limits in its formula.
        suggested: what a requirement rests on that was suggested from runs; empty for others.
        accepted: who accepted such a requirement, and when.
    """

    title: str
    source: str
    text: str
    group: str = ""
    suggested: str = ""
    accepted: str = ""
    reads: Names = ()
    limits: tuple[RequirementLimit, ...] = ()


class ModelSource(PlainRecord, frozen=True, kw_only=True):
    """The AgentSpeak source of an agent whose plans are covered; `plans` is label -> line."""

    file: str
    source: str
    plans: Mapping[str, Count]


class RerunOptions(PlainRecord, frozen=True, kw_only=True):
    """The value of `--hri-suite`, and the other options needed to rerun a test."""

    suite: str
    options: tuple[RerunOption, ...]


class SessionSummary(PlainRecord, frozen=True, kw_only=True):
    """One of the sessions that a report was merged from; `sha256` is of its report.json."""

    sha256: str
    wall_s: NotNegative
    workers: Count
    selected: Count
    reported: Count
    shard: Shard
    origin: ReportOrigin | None = None


class NcExemption(PlainRecord, frozen=True, kw_only=True):
    """Why a requirement need not be triggered, in which suites (empty: in all), and up to which day (YYYY-MM-DD)."""

    reason: str
    suites: Names = ()
    until: str = ""


class GatePolicy(PlainRecord, frozen=True, kw_only=True):
    """The gates that a session was asked to keep: least percentage by kind, and what else fails it."""

    thresholds: Mapping[str, Percent] = {}
    fail_on_nc: bool = False
    fail_on_change: bool = False
    fail_on_pending: bool = False


class GateResult(PlainRecord, frozen=True, kw_only=True):
    """Failures of the session besides its tests, and improvements, a sentence each.

    Args:
        differences: from the baseline; the sentences of each are in one of the others, too.
    """

    failed: Names
    improved: Names
    differences: tuple[Difference, ...] = ()


class Report(PlainRecord, frozen=True, kw_only=True):
    """All of `report.json`.

    Args:
        known_violations: requirement -> the reason why its violation is known.
        known_when: requirement -> the condition under which its violation is known; the others are known everywhere.
        allowed_untriggered: requirement -> why it need not be triggered.
        known_until: requirement -> the last day (YYYY-MM-DD) on which its violation is known.
        strict: whether the list of known violations was ignored.
        state: the message and field that tell the robot's state, as `topic.field`.
        models: agent -> source, of the agents whose plans are covered.
        closure: over the tests of all suites.
        units: signal -> unit; in a merged report, where all sessions had the same.
        sampled_while: signal -> the bool signal that is on while the world measures it; between, plots have a gap.
        outcome_label: what the testbench calls the interactions, which views list by their outcomes.
        shard: of a session that ran one part of the suites: which, as in 2/3.
        sessions: in a merged report, the sessions from which it was merged.
        gates: None if the session did not come to its end, or ran a shard.
        environment: name -> version, what records can depend on besides code and testbench; of a merged report, where
            all sessions had the same.
        policy: the gates that were asked for; of a merged report, those of all sessions.
        problems: what went wrong besides tests and gates, a sentence each; it fails a merge, too.
        changes: how its tests behave, compared with a baseline.
        origin: where it comes from; of a merged one, its sessions have theirs.
        full_report: of a session that ran a part of its suites: the page of the last full one, relative to the report.
    """

    schema: Literal["hricdv-report/3"]
    version: str
    testbench: str
    selected: Count
    reported: Count
    not_run: Count
    not_run_tests: Names
    wall_s: NotNegative
    workers: Count
    known_violations: Mapping[str, str]
    known_until: Mapping[str, str]
    strict: bool
    rerun_options: RerunOptions
    requirements: Mapping[str, RequirementText]
    state: str
    code_under_test: ReportedCode
    models: Mapping[str, ModelSource]
    cross_products: Mapping[str, ProductDeclaration]
    exploration: ExplorationRecord
    suites: tuple[SuiteResult, ...]
    closure: Closure
    tests: tuple[TestResult, ...]
    units: Mapping[str, str] | None = None
    sampled_while: Mapping[str, str] = {}
    outcome_label: str = "interactions"
    shard: Shard = ""
    sessions: tuple[SessionSummary, ...] = ()
    gates: GateResult | None = None
    policy: GatePolicy | None = None
    problems: Names = ()
    known_when: Mapping[str, str] = {}
    allowed_untriggered: Mapping[str, NcExemption] = {}
    environment: Mapping[str, str] = {}
    changes: BehaviourChanges | None = None
    full_report: Literal["", "whole/index.html"] = ""
    origin: ReportOrigin | None = None


if not TYPE_CHECKING:  # with the keys of features, which only the features themselves know by type
    TestResult = extend_record(TestResult, test_sections())
    Report = extend_record(Report, report_sections())
