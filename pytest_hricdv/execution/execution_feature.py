"""The interface by which a feature takes part in the execution of tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from typing import Protocol

from pytest_hricdv.declarations.ros2_system import Middleware
from pytest_hricdv.execution.faults import CodeUnderTest
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import Criterion, Verdict
from pytest_hricdv.monitor.names import Kind
from pytest_hricdv.registry import offers
from pytest_hricdv.run import Run
from pytest_hricdv.runtime.json_value import Value
from pytest_hricdv.testbench import Testbench


class Watcher(Protocol):
    """Receives the messages and signals of a run, as monitors do."""

    def message(self, time_s: float, topic: str, fields: Mapping[str, Value]) -> None: ...

    def signal(self, time_s: float, name: str, value: Value) -> None: ...


class Follower(Watcher, Protocol):
    """Watches a run and judges it at its end."""

    def finish(self, time_s: float) -> Verdict:
        """The run ended at `time_s` (s of simulated time): the verdict."""


class ExecutionFeature:
    """What a feature does for runs, its `EXECUTION`; the methods do nothing by default.

    Its module is loaded with every testbench, even one without the feature: heavy imports belong into methods.

    Attributes:
        preloaded: modules that a process imports once which runs tests in forks of itself.
    """

    preloaded: tuple[str, ...] = ()

    def prepare(self, testbench: Testbench) -> None:
        """Before the vocabulary of a testbench is asked for, in each process that loads it.

        Raises:
            Ros2Error: what the testbench declares cannot be had in this process.
        """

    def topics(self, testbench: Testbench) -> Mapping[str, Mapping[str, Kind]]:
        """What requirements can name of a middleware other than the bus: name -> its fields, with their types.

        Raises:
            Ros2Error: what the testbench declares of it is wrong.
        """
        return {}

    def before_imports(self, testbench: Testbench) -> tuple[str, ...]:
        """Functions, as "package.module:name", to be called in a process before it imports the code under test."""
        return ()

    def criteria(self, testbench: Testbench) -> tuple[Criterion, ...]:
        """What runs are judged by, besides the requirements.

        Raises:
            InputError: what the testbench declares of it is wrong.
        """
        return ()

    def followers(self, criteria: Sequence[Criterion], test: ConcreteTest) -> tuple[Follower, ...]:
        """For one run: what judges it by those of the criteria that are the feature's, a verdict for each one."""
        return ()

    def surround(self, run: Run, code: CodeUnderTest, testbench: Testbench) -> AbstractContextManager[None]:
        """Entered around a run."""
        return nullcontext()

    def middleware(self, testbench: Testbench) -> Middleware | None:
        """For one run: what the code under test runs on; None where that is the bus, or another feature has it."""
        return None


def execution_features() -> tuple[ExecutionFeature, ...]:
    """All that take part in execution."""
    return offers("execution", "EXECUTION")
