"""`OracleExecution`: makes the model's agent one more criterion of each run, if the testbench declares it as an oracle.

`case.execute` calls it, as an `ExecutionFeature`.
"""

from __future__ import annotations

from collections.abc import Sequence

from pytest_hricdv.execution.execution_feature import ExecutionFeature, Follower
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import Criterion, Requirement
from pytest_hricdv.testbench import Testbench

_MONITOR = "pytest_hricdv.extra.oracle.conformance_monitor"


class OracleExecution(ExecutionFeature):
    """The agent that each run of a testbench is compared with, where it declares one."""

    preloaded = (_MONITOR,)

    def criteria(self, testbench: Testbench) -> tuple[Criterion, ...]:
        """The agent, ready for runs; none if the testbench declares none.

        Raises:
            ModelOracleError: a correspondence names what the model, or the run, does not have.
            RequirementError: a condition of it does not parse.
        """
        if testbench.oracle is None:
            return ()
        from pytest_hricdv.extra.oracle.oracle import load_oracle

        vocabulary, parameters = testbench.vocabulary(), testbench.concretization.run
        return (load_oracle(testbench.oracle, testbench.model, vocabulary, parameters),)

    def followers(self, criteria: Sequence[Criterion], test: ConcreteTest) -> tuple[Follower, ...]:
        """A monitor for the agent, if it is one of the criteria."""
        others = [criterion for criterion in criteria if not isinstance(criterion, Requirement)]
        if not others:
            return ()
        from pytest_hricdv.extra.oracle.conformance_monitor import ConformanceMonitor  # loads the BDI engine
        from pytest_hricdv.extra.oracle.oracle import Oracle

        return tuple(ConformanceMonitor(oracle, test.run) for oracle in others if isinstance(oracle, Oracle))


EXECUTION = OracleExecution()
