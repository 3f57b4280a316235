"""`HriCase`, the value of the fixture `hri_case`: a generated test, which its test function runs and checks.

`session.suites.cases` makes one for each concrete test; `TestRunner` sets its `runner` and `checker` before the call.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.execution.outcome import Judgement
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import UNIFORM, ConcreteTest, Concretization, concretize

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too


@dataclass(repr=False)
class HriCase:
    """The argument `hri_case` of a test function.

    >>> def test_table_assembly(hri_case):          # doctest: +SKIP
    ...     hri_case.check(hri_case.run())
    """

    suite: str
    abstract: AbstractTest
    ranges: Concretization
    sampling: str = UNIFORM
    fixed: ConcreteTest | None = None
    """The concrete test to run if it is replayed or rerun: nothing is sampled then."""
    result: CaseResult | None = None
    """Result of the first run that failed, or else of the last run."""
    checked: CaseResult | None = None
    """The result that was checked last."""
    judgement: Judgement | None = None
    """The judgement of this result."""
    raised: BaseException | None = None
    """What the first run that failed raised, or its judgement: no later run makes it good."""
    runner: Callable[[HriCase], CaseResult] | None = None
    checker: Callable[[HriCase, CaseResult], None] | None = None
    is_elsewhere: bool = False
    """Whether another process runs and reports it."""

    @cached_property
    def concrete(self) -> ConcreteTest:
        """The test with its parameters, sampled on first use: collecting thousands must be fast."""
        return self.fixed or concretize(self.abstract, self.ranges, sampling=self.sampling)

    def run(self) -> CaseResult:
        """Run the test in the simulated world, watched by the monitors."""
        if self.runner is None:
            raise RuntimeError("hri_case.run: expected inside of its own test, or of a fixture that sets this up")
        if self.result is not None and self.checked is not self.result:
            self.check(self.result)  # before another one takes its place
        try:
            result = self.runner(self)
        except BaseException as error:
            self.raised = self.raised or error
            raise
        if self.raised is None:
            self.result = result
        return result

    def check(self, result: CaseResult) -> None:
        """Fail, once and with every violation, on a violation that is not known, or on a fault of the run.

        Called after the test if the test has not called it, so that no violation is missed.
        """
        if self.checker is None:
            raise RuntimeError("hri_case.check: expected inside of its own test, or of a fixture that sets this up")
        if self.raised is not None:
            raise self.raised
        self.checked = result
        self.checker(self, result)

    def forget(self) -> None:
        """Release the run, and parameters that can be sampled again."""
        self.result = self.checked = self.judgement = self.raised = None
        self.__dict__.pop("concrete", None)

    def __repr__(self) -> str:
        return f"<hri_case {self.abstract.id}>"
