"""One generated test: what `hri_case` is, and how it runs."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Mapping
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, field
from functools import cached_property

from msgspec.structs import replace

from pytest_hricdv._base import process_state
from pytest_hricdv.coverage.code_map import Bits
from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.coverage.measurement import Measurement, NoMeasurement
from pytest_hricdv.coverage.own_coverage import debugger
from pytest_hricdv.execution import faults
from pytest_hricdv.execution.deadlock import find_deadlocks
from pytest_hricdv.execution.execution_feature import Follower, Watcher, execution_features
from pytest_hricdv.execution.faults import CodeUnderTest
from pytest_hricdv.execution.host_loop import leave_host_loop
from pytest_hricdv.execution.influence import Influence, ParameterLog
from pytest_hricdv.execution.outcome import Judgement
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.actors import actors_of
from pytest_hricdv.generate.concrete import UNIFORM, ConcreteTest, Concretization, concretize
from pytest_hricdv.monitor import (
    Criterion,
    Log,
    MonitorSet,
    PastFormula,
    Requirement,
    Verdict,
    Vocabulary,
    explain,
    watch,
)
from pytest_hricdv.run import Actions
from pytest_hricdv.runtime import Bus, Kernel, NodeError, Record, Recorder
from pytest_hricdv.runtime.json_value import Value
from pytest_hricdv.runtime.random_numbers import seed_run
from pytest_hricdv.runtime.termination import refusal, word_of
from pytest_hricdv.runtime.virtual import VirtualModules
from pytest_hricdv.runtime.virtual.outside import guard_run
from pytest_hricdv.testbench import Outcome, Run, Testbench, TestbenchError

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too


UNMEASURED = NoMeasurement("nobody asked for it")


class MonitorFeed:
    """Forwards events of the record to the monitors: those that the vocabulary names, numbers as floats."""

    def __init__(self, monitors: Watcher, vocabulary: Vocabulary) -> None:
        self._monitors = monitors
        self._fields = {topic: dict(fields) for topic, fields in vocabulary.messages.items()}
        self._signals = dict(vocabulary.signals)

    def message(self, time_s: float, topic: str, fields: Mapping[str, Value]) -> None:
        """See `runtime.record.Listener`. A field that is not as its class declares it is a TypeError."""
        kinds = self._fields.get(topic)
        if kinds is None:
            return  # a topic of ROS 2 that the testbench does not declare, so no requirement names it
        for name, kind in kinds.items():
            value = fields.get(name)
            if value is None or not (_is_of(kind, value) or (kind is not str and isinstance(value, int))):
                raise TypeError(f"{topic}.{name} is {value!r} at {time_s:.6f} s: declared as {kind.__name__}")
        self._monitors.message(time_s, topic, {name: kind(fields[name]) for name, kind in kinds.items()})

    def signal(self, time_s: float, name: str, value: float | bool | str) -> None:
        """See `runtime.record.Listener`.

        Raises:
            KeyError: the testbench did not declare such a signal.
            TypeError: it declared it with another type.
        """
        kind = self._signals.get(name)
        if kind is None:
            raise KeyError(f"signal {name!r} is recorded but not declared in the testbench's signals")
        if not _is_of(kind, value):
            where = f"signal {name} is {value!r} at {time_s:.6f} s"
            raise TypeError(f"{where}: the testbench declares it as {kind.__name__}")
        self._monitors.signal(time_s, name, value)


def _is_of(kind: type, value: Value) -> bool:
    """Whether a value is of a declared type; a whole number is a float, a bool is none."""
    if kind is float:
        return isinstance(value, float | int) and not isinstance(value, bool)
    return isinstance(value, kind)


@dataclass(frozen=True)
class CaseResult:
    """The result of one run: outcome, record, a verdict per requirement, and coverage (None: unmeasured)."""

    test: ConcreteTest
    outcome: Outcome
    record: Record
    sim_s: float
    verdicts: tuple[Verdict, ...]
    code: Bits | None
    cross: Mapping[str, tuple[Bin, ...]] = field(default_factory=dict)
    """The bins that the run hit, by cross product, verdicts included."""
    action_times_s: tuple[float, ...] = ()
    """When the test's actions began (s of simulated time), as far as the testbench's `run` reported it, ascending."""
    begun: tuple[int, ...] = ()
    """Which actions these are, by their numbers from 0: several actors need not begin theirs in the text's order."""
    bystander_events: tuple[tuple[float, str], ...] = ()
    """What bystanders have begun, and when (s)."""
    ending_faults: tuple[str, ...] = ()
    """What is wrong with how the run ended, a sentence each (see `pytest_hricdv.execution.faults`)."""
    bin_faults: tuple[str, ...] = ()
    """What is wrong with the bins that the run hit, a sentence each."""
    unreached_waits: str = ""
    """When the code waited, where nothing that people, sensors or the world did reached it (see `Influence.waits`)."""
    unread: tuple[str, ...] = ()
    """Parameters of a run that the testbench declares, and that nobody read in this one."""
    has_measured_node: bool = True
    """Whether the testbench's `run` wrapped a node with `run.measured`: otherwise nothing of the code was measured."""
    threads: int = 0
    """How many nodes of the code under test there were: its threads, and nodes of ROS 2."""
    error: NodeError | None = None
    """The failure of a node that ended the run; it is one of the faults."""
    notes: tuple[str, ...] = ()
    """What its middleware has to say of the run, though it fails nothing, a sentence each."""
    engine: str = ""
    """The physics engine that it ran on; empty where the testbench has none."""
    cross_check: CaseResult | None = field(default=None, repr=False)
    """The same test on a second engine, of a session in which engines check each other."""

    @property
    def errors(self) -> tuple[str, ...]:
        """What is wrong with the run beside its requirements, a sentence each."""
        return (*self.ending_faults, *self.bin_faults)

    @property
    def failed(self) -> tuple[str, ...]:
        """The requirements that the run violated."""
        return tuple(verdict.requirement for verdict in self.verdicts if verdict.verdict == "Failed")

    def verdict(self, requirement: str) -> Verdict:
        """The verdict of one requirement. Raises KeyError for one that does not exist."""
        return {verdict.requirement: verdict for verdict in self.verdicts}[requirement]


@dataclass(frozen=True)
class RunSettings:
    """What runs are judged and measured with.

    Args:
        testbench: they are run with.
        requirements: of the testbench, loaded, and the agent that each run is compared with, if there is one.
        known_when: requirement -> condition under which its violations are known; others are marked as outside.
        measurement: measures the code under test.
    """

    testbench: Testbench
    requirements: tuple[Criterion, ...] = ()
    known_when: Mapping[str, PastFormula] = field(default_factory=dict)
    measurement: Measurement = UNMEASURED

    def with_measurement(self, measurement: Measurement) -> RunSettings:
        """The same, with the code under test measured by another one."""
        return RunSettings(self.testbench, self.requirements, self.known_when, measurement)


def execute(
    settings: RunSettings,
    test: ConcreteTest,
    context: str = "",
    *,
    filming: Callable[[Run], AbstractContextManager[None]] | None = None,
    producing: Actions | None = None,
    watching: Iterable[Watcher] = (),
    begun: Callable[[CodeUnderTest], None] = lambda code: None,
) -> CaseResult:
    """Run one concrete test: a pure function of the test and the code.

    Args:
        settings: what the run is judged and measured with.
        context: name of this test's share of the measurement.
        filming: see `Run`.
        producing: produces the actions while the run goes on; the result's test has those that were taken (see
            `Run.enacted`).
        watching: who else sees the run, before what produces its actions asks them.
        begun: called before the run, with what knows the nodes of the code under test.

    Raises:
        TestbenchError: the testbench's `run` returned no Outcome, or ended the test by `pytest.skip` or the like.
        NodeError: a node failed, and after that the testbench or the monitors could not finish the run.
    """
    testbench, measurement, given = settings.testbench, settings.measurement, test
    parameters = ParameterLog(given.run)
    test = dataclasses.replace(given, run=parameters)
    recorder = Recorder()
    monitors = MonitorSet(formulas(settings.requirements))
    followers = tuple(
        follower for feature in execution_features() for follower in feature.followers(settings.requirements, test)
    )
    vocabulary = testbench.vocabulary()
    watchers: tuple[Watcher, ...] = (monitors, *followers, *watching)
    recorder.listeners += [MonitorFeed(watcher, vocabulary) for watcher in watchers]
    # Disable the watchdog while debugging.
    kernel = Kernel(stuck_after_s=math.inf if debugger() else testbench.time.stall_timeout_s)
    code = CodeUnderTest(kernel, lambda body: measurement.measure(context, body))
    begun(code)
    run = Run(
        test=test,
        kernel=kernel,
        bus=Bus(kernel, testbench.messages, recorder, code.is_running),
        recorder=recorder,
        measured=code.node,
        monitors=monitors,
        filming=filming,
        fidelity=testbench.simulation.fidelity,
        engine=testbench.simulation.engine,
        disturbances=testbench.disturbances,
        producing=producing,
        actors=testbench.model.who_acts,
        bystanders={bystander.name: bystander for bystander in testbench.people.bystanders},
        may_go_round=bool({"limit", "cycle"}.intersection(testbench.time.allowed_endings)),
    )
    influence = Influence(kernel, run.bus, code.has, testbench.code)
    deadlocks: list[str] = []

    def before_end() -> None:
        influence.finish()
        deadlocks.extend(find_deadlocks([node for node in kernel.nodes if code.has(node)]))

    run.before_end = before_end
    kernel.virtual = frozenset(testbench.time.apis)
    modules = VirtualModules(testbench.code)
    run.middleware = next(filter(None, (feature.middleware(testbench) for feature in execution_features())), None)
    if run.middleware is not None:
        modules = run.middleware.modules
        kernel.virtual |= run.middleware.virtual
    kernel.code = modules.packages
    tampering: tuple[str, ...] = ()
    try:
        with (
            leave_host_loop(),
            measurement.watch_imports(context),
            modules.install(),
            guard_run(kernel),
            seed_run(test.seed),
            kernel.supervision.watch(),
            ExitStack() as stack,
        ):
            for feature in execution_features():
                stack.enter_context(feature.surround(run, code, testbench))
            state = process_state.ProcessState()
            try:
                outcome, verdicts, record = _finish(settings, followers, run)
            finally:
                tampering = state.put_back()
    except BaseException as error:
        failed = run.ending.error if isinstance(error, Exception) and run.ending is not None else None
        raised = failed or error
        for sentence in tampering:
            (raised.__cause__ or raised).add_note(sentence)  # a cause is what is shown
        if failed is not None:
            raise failed from failed.__cause__  # what fails after it may be its consequence
        if word_of(error):
            raise TestbenchError(refusal(error)) from error
        raise
    finally:
        measurement.settle()
    cross, bin_faults = faults.of_bins(testbench, outcome, verdicts)
    covered = measurement.take(context)
    ended = [*faults.of_ending(run.ending, code, testbench.time.allowed_endings)] if run.ending else []
    ended += faults.of_simulation(kernel, run.ending)
    ended += [*deadlocks, *tampering]
    ended += faults.of_actors(name for name in run.idle_actors() if _acts(name, testbench))
    ended += run.middleware.stuck_nodes if run.middleware is not None else ()
    return CaseResult(
        test=dataclasses.replace(run.enacted, run=given.run),
        outcome=outcome,
        record=record,
        sim_s=kernel.now_s,
        verdicts=verdicts,
        code=covered if code.has_run else None,
        has_measured_node=code.has_run,
        threads=code.threads,
        unreached_waits=influence.waits if code.has_run else "",
        unread=tuple(name for name in testbench.concretization.run if name in parameters.unread),
        cross=cross,
        action_times_s=tuple(run.action_times_s),
        begun=tuple(run.begun),
        bystander_events=tuple(run.bystander_events),
        ending_faults=tuple(ended),
        bin_faults=tuple(bin_faults),
        error=run.ending.error if run.ending else None,
        notes=run.middleware.notes if run.middleware is not None else (),
        engine=testbench.simulation.engine,
    )


def _acts(name: str, testbench: Testbench) -> bool:
    """Whether somebody can do anything: an actor of the model may only tell others something."""
    return name not in testbench.model.actors or name in actors_of(testbench.concretization.commands)


def part_criteria(testbench: Testbench) -> tuple[Criterion, ...]:
    """What runs of a testbench are judged by beside its requirements: optional parts add it.

    Raises:
        InputError: what the testbench declares for a feature is wrong.
        RequirementError: a condition in it does not parse.
    """
    return tuple(criterion for feature in execution_features() for criterion in feature.criteria(testbench))


def formulas(requirements: Iterable[Criterion]) -> tuple[Requirement, ...]:
    """Those that are formulas, which monitors follow."""
    return tuple(criterion for criterion in requirements if isinstance(criterion, Requirement))


def _finish(
    settings: RunSettings, followers: tuple[Follower, ...], run: Run
) -> tuple[Outcome, tuple[Verdict, ...], Record]:
    """Run it to its end: what the testbench says of it, the verdicts, and the record."""
    outcome = settings.testbench.run(run)
    if not isinstance(outcome, Outcome):
        raise TestbenchError(f"the testbench's run returned {outcome!r}; expected a pytest_hricdv.testbench.Outcome")
    record, end_s = run.recorder.finish(), run.kernel.now_s
    log = log_of(record, end_s)
    verdicts = explain(run.monitors.finish(end_s), formulas(settings.requirements), log)
    verdicts += tuple(follower.finish(end_s) for follower in followers)
    return outcome, tuple(_mark(verdict, settings.known_when, log) for verdict in verdicts), record


def log_of(record: Record, end_s: float) -> Log:
    """What requirements are judged by: a record without its disturbances."""
    heard = tuple(message for message in record.messages if not message.is_disturbance)
    return Log({**record.signals, **record.texts}, heard, end_s)


def _mark(verdict: Verdict, known_when: Mapping[str, PastFormula], log: Log) -> Verdict:
    """The verdict, with violations marked that are outside of the condition under which they are known."""
    if not verdict.violations or verdict.requirement not in known_when:
        return verdict
    condition = watch(known_when[verdict.requirement], log)
    violations = (
        replace(violation, outside=not condition.holds_at(violation.time_s)) for violation in verdict.violations
    )
    return replace(verdict, violations=tuple(violations))


@dataclass(repr=False)
class HriCase:
    """What a test function gets as `hri_case`.

    >>> def test_table_assembly(hri_case):          # doctest: +SKIP
    ...     hri_case.check(hri_case.run())
    """

    suite: str
    abstract: AbstractTest
    ranges: Concretization
    sampling: str = UNIFORM
    fixed: ConcreteTest | None = None
    """The concrete test to run, of a test that is repeated: nothing is sampled then."""
    result: CaseResult | None = None
    """Of the last run."""
    checked: CaseResult | None = None
    """What was checked last."""
    judgement: Judgement | None = None
    """Of what was checked last."""
    raised: BaseException | None = None
    """What was raised for the judgement: where this ended the test, the judgement did."""
    runner: Callable[[HriCase], CaseResult] | None = None
    checker: Callable[[HriCase, CaseResult], None] | None = None
    is_elsewhere: bool = False
    """Another process runs it, and makes its report."""

    @cached_property
    def concrete(self) -> ConcreteTest:
        """The test with its parameters, sampled at the first use, because collecting thousands must be fast."""
        return self.fixed or concretize(self.abstract, self.ranges, sampling=self.sampling)

    def run(self) -> CaseResult:
        """Run the test in the simulated world, watched by the monitors."""
        if self.runner is None:
            raise RuntimeError("hri_case.run: expected inside of its own test, or of a fixture that sets this up")
        self.result = self.runner(self)
        return self.result

    def check(self, result: CaseResult) -> None:
        """Fail, once and with every violation, when a requirement failed that is not a known violation, or at a fault.

        If a test does not call this, it is done after the test, so that no violation is missed.
        """
        if self.checker is None:
            raise RuntimeError("hri_case.check: expected inside of its own test, or of a fixture that sets this up")
        self.checked = result
        self.checker(self, result)

    def forget(self) -> None:
        """Release the run, and parameters that can be sampled again."""
        self.result = self.checked = self.judgement = self.raised = None
        self.__dict__.pop("concrete", None)

    def __repr__(self) -> str:
        return f"<hri_case {self.abstract.id}>"
