"""One generated test: what `hri_case` is, and how it runs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from functools import cached_property

from pytest_hricdv.coverage.code_map import Bits, CoverageError
from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.coverage.measurement import Measurement, debugger
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import UNIFORM, ConcreteTest, Concretization, concretize
from pytest_hricdv.monitor import Log, MonitorSet, Requirement, Verdict, Vocabulary, explained
from pytest_hricdv.runtime import Bus, Kernel, Record, Recorder
from pytest_hricdv.runtime.bus import Value
from pytest_hricdv.testbench import Outcome, Run, Testbench, TestbenchError

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too


class MonitorFeed:
    """Forwards events of the record to the monitors: those that the vocabulary names, numbers as floats."""

    def __init__(self, monitors: MonitorSet, vocabulary: Vocabulary) -> None:
        self._monitors = monitors
        self._fields = {topic: dict(fields) for topic, fields in vocabulary.messages.items()}
        self._signals = frozenset(vocabulary.signals)

    def message(self, time_s: float, topic: str, fields: Mapping[str, Value]) -> None:
        """See `runtime.bus.Listener`."""
        kinds = self._fields[topic]
        self._monitors.message(time_s, topic, {name: kind(fields[name]) for name, kind in kinds.items()})

    def signal(self, time_s: float, name: str, value: float | bool) -> None:
        """See `runtime.bus.Listener`. A signal the testbench did not declare is a KeyError."""
        if name not in self._signals:
            raise KeyError(f"signal {name!r} is recorded but not declared in the testbench's signals")
        self._monitors.signal(time_s, name, value)


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
    acted_s: tuple[float, ...] = ()
    """When each of the test's actions began (s of simulated time), as far as the testbench's `run` reported it."""

    @property
    def failed(self) -> tuple[str, ...]:
        """The requirements that the run violated."""
        return tuple(verdict.requirement for verdict in self.verdicts if verdict.verdict == "Failed")

    def illegal(self, testbench: Testbench) -> tuple[str, ...]:
        """What the run hit that the testbench's cross products forbid, a sentence each."""
        return tuple(
            f"cross product {name!r}: {' x '.join(each)} must not be hit: {testbench.cross[name].forbidden[each]}"
            for name, hits in self.cross.items()
            for each in sorted(set(hits) & testbench.cross[name].forbidden.keys())
        )

    def verdict(self, requirement: str) -> Verdict:
        """The verdict of one requirement. Raises KeyError for one that does not exist."""
        return {verdict.requirement: verdict for verdict in self.verdicts}[requirement]


def execute(
    testbench: Testbench,
    requirements: tuple[Requirement, ...],
    test: ConcreteTest,
    measurement: Measurement,
    context: str,
    filming: Callable[[Run], AbstractContextManager[None]] | None = None,
) -> CaseResult:
    """Run one concrete test: a pure function of the test and the code.

    Args:
        requirements: of the testbench, loaded.
        measurement: measures the code under test.
        context: name of this test's share of the measurement.
        filming: see `Run`.

    Raises:
        KernelError: a node failed; the text names it and the simulated time.
        TestbenchError: the testbench's `run` returned no Outcome.
        CoverageError: the outcome has a bin that its cross product has not.
    """
    recorder = Recorder()
    monitors = MonitorSet(requirements)
    recorder.listeners.append(MonitorFeed(monitors, testbench.vocabulary()))
    # Disable the watchdog while debugging.
    kernel = Kernel(stuck_after_s=math.inf if debugger() else None)
    run = Run(
        test=test,
        kernel=kernel,
        bus=Bus(kernel, testbench.messages, recorder),
        recorder=recorder,
        measured=lambda body: measurement.measured(context, body),
        monitors=monitors,
        filming=filming,
    )
    outcome = testbench.run(run)
    if not isinstance(outcome, Outcome):
        raise TestbenchError(f"the testbench's run returned {outcome!r}; expected a pytest_hricdv.testbench.Outcome")
    record = recorder.finish()
    log = Log(record.signals, record.messages, kernel.now_s)
    verdicts = explained(monitors.finish(kernel.now_s), requirements, log)
    cross = _crossed(testbench, outcome, verdicts)
    code, acted_s = measurement.take(context), tuple(run.acted_s)
    return CaseResult(test, outcome, record, kernel.now_s, verdicts, code, cross, acted_s)


def _crossed(testbench: Testbench, outcome: Outcome, verdicts: tuple[Verdict, ...]) -> dict[str, tuple[Bin, ...]]:
    for name in outcome.cross:
        if name not in testbench.cross:
            known = ", ".join(testbench.cross) or "none"
            raise CoverageError(f"cross product: run told bins of {name!r}, but declared are: {known}")
    judged = {verdict.requirement: verdict.verdict for verdict in verdicts}
    return {
        name: product.check(product.with_verdicts(outcome.cross.get(name, ()), judged), f"cross product {name!r}")
        for name, product in testbench.cross.items()
    }


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
    checked: bool = False
    runner: Callable[[HriCase], CaseResult] | None = None
    judge: Callable[[HriCase, CaseResult], None] | None = None

    @cached_property
    def concrete(self) -> ConcreteTest:
        """The test with its parameters, sampled at the first use, because collecting thousands must be fast."""
        return self.fixed or concretize(self.abstract, self.ranges, sampling=self.sampling)

    def run(self) -> CaseResult:
        """Run the test in the simulated world, watched by the monitors."""
        assert self.runner is not None, "hri_case can be run only inside its own test"
        self.result = self.runner(self)
        return self.result

    def check(self, result: CaseResult) -> None:
        """Fail, once and with every violation, when a requirement failed that is not a known violation.

        If a test does not call this, it is done after the test, so that no violation is missed.
        """
        assert self.judge is not None, "hri_case can be checked only inside its own test"
        self.checked = True
        self.judge(self, result)

    def forget(self) -> None:
        """Release the run, and parameters that can be sampled again."""
        self.result = None
        self.__dict__.pop("concrete", None)

    def __repr__(self) -> str:
        return f"<hri_case {self.abstract.id}>"
