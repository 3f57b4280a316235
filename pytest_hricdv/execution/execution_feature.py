"""`ExecutionFeature`: the interface by which a feature, such as ROS 2, takes part in the execution of tests.

`execution_features` returns those of all installed features; `case.execute` calls them in each run.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import Protocol

from pytest_hricdv.declarations.ros2 import Middleware
from pytest_hricdv.execution.faults import CodeUnderTest
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import Criterion, Verdict
from pytest_hricdv.monitor.node import Kind
from pytest_hricdv.registry import offers
from pytest_hricdv.run import Run
from pytest_hricdv.runtime.record import Value
from pytest_hricdv.testbench import Testbench


class Watcher(Protocol):
    """Receives the messages and signals of a run, as monitors do."""

    def message(self, time_s: float, topic: str, fields: Mapping[str, Value]) -> None: ...

    def signal(self, time_s: float, name: str, value: Value) -> None: ...


class Follower(Watcher, Protocol):
    """Watches a run and judges it at its end."""

    def finish(self, time_s: float) -> Verdict:
        """The verdict on the run, which ended at `time_s` (s of simulated time)."""


class ExecutionFeature:
    """A feature's part in runs, its `EXECUTION`; the methods do nothing by default.

    Its module is loaded with every testbench, even one without the feature: heavy imports belong in methods.

    Attributes:
        preloaded: modules to import in a process before it forks to run tests, so that not every fork imports them.
    """

    preloaded: tuple[str, ...] = ()

    def prepare(self, testbench: Testbench) -> None:
        """Prepare each process that loads a testbench, before its vocabulary is used.

        Raises:
            Ros2Error: what the testbench declares cannot be had in this process.
        """

    def topics(self, testbench: Testbench) -> Mapping[str, Mapping[str, Kind]]:
        """Names of a middleware other than the bus that requirements can use -> their fields, with types.

        Raises:
            Ros2Error: what the testbench declares of it is wrong.
        """
        return {}

    def before_imports(self, testbench: Testbench) -> tuple[str, ...]:
        """Functions, as "package.module:name", that a process calls before it imports the code under test."""
        return ()

    def criteria(self, testbench: Testbench) -> tuple[Criterion, ...]:
        """Criteria that runs are judged by, besides the requirements.

        Raises:
            InputError: what the testbench declares of it is wrong.
        """
        return ()

    def followers(self, criteria: Sequence[Criterion], test: ConcreteTest) -> tuple[Follower, ...]:
        """The followers that judge one run by the feature's own criteria, a verdict for each."""
        return ()

    def surround(self, run: Run, code: CodeUnderTest, testbench: Testbench) -> AbstractContextManager[None]:
        """A context manager entered around a run."""
        return nullcontext()

    def middleware(self, testbench: Testbench) -> Middleware | None:
        """The middleware of the code under test in one run; None for the bus, or if another feature provides it."""
        return None


def execution_features() -> tuple[ExecutionFeature, ...]:
    """All features that take part in execution."""
    return offers("execution", "EXECUTION")
