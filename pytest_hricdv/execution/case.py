"""`execute` runs one concrete test in its testbench, under monitors and measurement, and returns a `CaseResult`.

`TestRunner` calls it for each test of a session; replays, custom tests, films, mutants and searches call it, too.
"""

from __future__ import annotations

import dataclasses
import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass, field

from pytest_hricdv._base import process_state
from pytest_hricdv.coverage.code_map import Bits
from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.coverage.measurement import Measurement, NoMeasurement
from pytest_hricdv.coverage.own_coverage import debugger
from pytest_hricdv.execution import faults
from pytest_hricdv.execution.execution_feature import Watcher, execution_features
from pytest_hricdv.execution.faults import CodeUnderTest
from pytest_hricdv.execution.influence import Influence, ParameterLog
from pytest_hricdv.execution.run_monitors import MonitorFeed, formulas, log_of, mark_unknown
from pytest_hricdv.generate.actors import actors_of
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import Criterion, MonitorSet, PastFormula, Verdict, explain
from pytest_hricdv.run import Actions
from pytest_hricdv.runtime import Bus, Kernel, NodeError, Record, Recorder
from pytest_hricdv.runtime.node_error import refusal, word_of
from pytest_hricdv.runtime.random_numbers import seed_run
from pytest_hricdv.runtime.virtual import VirtualModules
from pytest_hricdv.runtime.virtual.deadlocks import find_deadlocks
from pytest_hricdv.runtime.virtual.outside import guard_run
from pytest_hricdv.runtime.virtual.prohibition import keep_builtins
from pytest_hricdv.testbench import Outcome, Run, Testbench, TestbenchError

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too

UNMEASURED = NoMeasurement("nobody asked for it")


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
    """The numbers of these actions, from 0: with several actors they may begin in another order than in the text."""
    bystander_events: tuple[tuple[float, str], ...] = ()
    """The acts that bystanders began, and when (s)."""
    ending_faults: tuple[str, ...] = ()
    """Faults of the run's end, a sentence each (see `pytest_hricdv.execution.faults`)."""
    bin_faults: tuple[str, ...] = ()
    """Faults of the bins that the run hit, a sentence each."""
    unreached_waits: str = ""
    """When the code waited, if nothing that people, sensors or the world did reached it (see `Influence.waits`)."""
    unread: tuple[str, ...] = ()
    """Parameters of a run that the testbench declares, and that nobody read in this one."""
    has_measured_node: bool = True
    """Whether the testbench's `run` wrapped a node with `run.measured`: otherwise nothing of the code was measured."""
    threads: int = 0
    """Number of nodes of the code under test: threads, nodes of ROS 2, and tasks of asyncio except the first."""
    error: NodeError | None = None
    """The failure of a node that ended the run, which is one of the faults."""
    notes: tuple[str, ...] = ()
    """Notes of its middleware, which fail nothing, a sentence each."""
    engine: str = ""
    """The physics engine; empty if the testbench has none."""
    cross_check: CaseResult | None = field(default=None, repr=False)
    """The result of the same test on a second engine, if engines check each other."""

    @property
    def errors(self) -> tuple[str, ...]:
        """Faults of the run besides its requirements, a sentence each."""
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
    """The settings with which runs are judged and measured.

    Args:
        requirements: the testbench's requirements, loaded, and the agent that each run is compared with, if there is
            one.
        known_when: requirement -> condition under which its violations are known; others are marked as outside.
        measurement: measures the code under test.
    """

    testbench: Testbench
    requirements: tuple[Criterion, ...] = ()
    known_when: Mapping[str, PastFormula] = field(default_factory=dict)
    measurement: Measurement = UNMEASURED

    def with_measurement(self, measurement: Measurement) -> RunSettings:
        """These settings with another measurement."""
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
        producing: produces the actions during the run; the result's test has those that were taken (see
            `Run.enacted`).
        watching: who else sees the run, before what produces its actions asks them.
        begun: called before the run, with what knows the nodes of the code under test.

    Raises:
        TestbenchError: the testbench's `run` returned no Outcome, or ended the test by `pytest.skip` or the like.
        NodeError: a node failed, and after that the testbench or the monitors could not finish the run.
    """
    case = _CaseExecution(settings, test, context, watching)
    begun(case.code)
    case.prepare(filming, producing)
    judgement = case.carry_out()
    return case.sum_up(judgement)


@dataclass(frozen=True)
class _Judgement:
    """What the testbench and the monitors say of a run."""

    outcome: Outcome
    verdicts: tuple[Verdict, ...]
    record: Record


class _CaseExecution:
    """One run of a test, with what observes it."""

    def __init__(self, settings: RunSettings, test: ConcreteTest, context: str, watching: Iterable[Watcher]) -> None:
        testbench = settings.testbench
        self._settings, self._context, self._original = settings, context, test
        self._parameters = ParameterLog(test.run)
        self._test = dataclasses.replace(test, run=self._parameters)
        self._monitors = MonitorSet(formulas(settings.requirements))
        self._followers = tuple(
            follower
            for feature in execution_features()
            for follower in feature.followers(settings.requirements, self._test)
        )
        self._recorder = Recorder()
        vocabulary = testbench.vocabulary()
        for watcher in (self._monitors, *self._followers, *watching):
            self._recorder.listeners.append(MonitorFeed(watcher, vocabulary))
        # Disable the watchdog while debugging.
        self._kernel = Kernel(stuck_after_s=math.inf if debugger() else testbench.time.stall_timeout_s)
        self.code = CodeUnderTest(self._kernel, lambda body: settings.measurement.measure(context, body))
        self._deadlocks: list[str] = []
        self._tampering: tuple[str, ...] = ()

    def prepare(self, filming: Callable[[Run], AbstractContextManager[None]] | None, producing: Actions | None) -> None:
        """Make the run, and the modules that its code sees."""
        testbench, kernel, code = self._settings.testbench, self._kernel, self.code
        self._run = run = Run(
            test=self._test,
            kernel=kernel,
            bus=Bus(kernel, testbench.messages, self._recorder, code.is_running),
            recorder=self._recorder,
            measured=code.node,
            monitors=self._monitors,
            filming=filming,
            fidelity=testbench.simulation.fidelity,
            engine=testbench.simulation.engine,
            disturbances=testbench.disturbances,
            producing=producing,
            actors=testbench.model.who_acts,
            bystanders={bystander.name: bystander for bystander in testbench.people.bystanders},
            may_go_round=bool({"limit", "cycle"}.intersection(testbench.time.allowed_endings)),
        )
        self._influence = Influence(kernel, run.bus, code.has, testbench.code)
        run.before_end = self._before_end
        run.middleware = next(filter(None, (feature.middleware(testbench) for feature in execution_features())), None)
        kernel.virtual = frozenset(testbench.time.apis)
        self._modules = VirtualModules(testbench.code)
        if run.middleware is not None:
            self._modules = run.middleware.modules
            kernel.virtual |= run.middleware.virtual
        kernel.code = self._modules.packages

    def _before_end(self) -> None:
        self._influence.finish()
        self._deadlocks += find_deadlocks([node for node in self._kernel.nodes if self.code.has(node)])

    def carry_out(self) -> _Judgement:
        """Run it to its end. Raises as `execute`."""
        measurement, run = self._settings.measurement, self._run
        try:
            with (
                _leave_host_loop(),
                measurement.watch_imports(self._context),
                self._modules.install(),
                guard_run(self._kernel),
                keep_builtins(),
                process_state.hide_arguments(),
                seed_run(self._test.seed),
                self._kernel.supervision.watch(),
                ExitStack() as stack,
            ):
                for feature in execution_features():
                    stack.enter_context(feature.surround(run, self.code, self._settings.testbench))
                return self._finish()
        except BaseException as error:
            failed = run.ending.error if isinstance(error, Exception) and run.ending is not None else None
            raised = failed or error
            for sentence in self._tampering:
                (raised.__cause__ or raised).add_note(sentence)  # a cause is what is shown
            if failed is not None:
                raise failed from failed.__cause__  # what fails after it may be its consequence
            if word_of(error):
                raise TestbenchError(refusal(error)) from error
            raise
        finally:
            measurement.settle()

    def _finish(self) -> _Judgement:
        settings, run = self._settings, self._run
        state = process_state.ProcessState()
        try:
            outcome = settings.testbench.run(run)
            if not isinstance(outcome, Outcome):
                expected = "expected a pytest_hricdv.testbench.Outcome"
                raise TestbenchError(f"the testbench's run returned {outcome!r}; {expected}")
            record, end_s = run.recorder.finish(), self._kernel.now_s
            log = log_of(record, end_s)
            verdicts = explain(self._monitors.finish(end_s), formulas(settings.requirements), log)
            verdicts += tuple(follower.finish(end_s) for follower in self._followers)
            marked = tuple(mark_unknown(verdict, settings.known_when, log) for verdict in verdicts)
            return _Judgement(outcome, marked, record)
        finally:
            self._tampering = state.put_back(settings.testbench.code)

    def sum_up(self, judgement: _Judgement) -> CaseResult:
        """The result, with what was measured."""
        testbench, run, code, outcome = self._settings.testbench, self._run, self.code, judgement.outcome
        cross, bin_faults = faults.check_bins(testbench, outcome, judgement.verdicts)
        covered = self._settings.measurement.take(self._context)
        return CaseResult(
            test=dataclasses.replace(run.enacted, run=self._original.run),
            outcome=outcome,
            record=judgement.record,
            sim_s=self._kernel.now_s,
            verdicts=judgement.verdicts,
            code=covered if code.has_run else None,
            has_measured_node=code.has_run,
            threads=code.threads,
            unreached_waits=self._influence.waits if code.has_run else "",
            unread=tuple(name for name in testbench.concretization.run if name in self._parameters.unread),
            cross=cross,
            action_times_s=tuple(run.action_times_s),
            begun=tuple(run.begun),
            bystander_events=tuple(run.bystander_events),
            ending_faults=tuple(self._ending_faults()),
            bin_faults=tuple(bin_faults),
            error=run.ending.error if run.ending else None,
            notes=run.middleware.notes if run.middleware is not None else (),
            engine=testbench.simulation.engine,
        )

    def _ending_faults(self) -> Iterator[str]:
        testbench, run = self._settings.testbench, self._run
        if run.ending:
            yield from faults.check_ending(run.ending, self.code, testbench.time.allowed_endings)
        yield from faults.check_simulation(self._kernel, run.ending)
        yield from self._deadlocks
        yield from self._tampering
        yield from faults.check_actors(name for name in run.idle_actors() if _acts(name, testbench))
        if run.middleware is not None:
            yield from run.middleware.stuck_nodes


@contextmanager
def _leave_host_loop() -> Iterator[None]:
    """Hide the event loop of a test function that is a coroutine: asyncio would take it for that of all nodes."""
    asyncio = sys.modules.get("asyncio")
    if asyncio is None or asyncio._get_running_loop() is None:
        yield
        return
    from pytest_hricdv.runtime.virtual.event_loop import leave_loop

    go_on = leave_loop()
    try:
        yield
    finally:
        go_on()


def _acts(name: str, testbench: Testbench) -> bool:
    """Whether an actor can do anything: an actor of the model may only send messages to others."""
    return name not in testbench.model.actors or name in actors_of(testbench.concretization.commands)


def feature_criteria(testbench: Testbench) -> tuple[Criterion, ...]:
    """Criteria in addition to the requirements, which optional features add.

    Raises:
        InputError: what the testbench declares for a feature is wrong.
        RequirementError: a condition in it does not parse.
    """
    return tuple(criterion for feature in execution_features() for criterion in feature.criteria(testbench))
