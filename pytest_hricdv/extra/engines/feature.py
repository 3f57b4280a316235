"""The choice of a physics engine in a session, and tests that run on two, which check each other."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import pytest

from pytest_hricdv._base.message import visible
from pytest_hricdv.session.feature import Feature
from pytest_hricdv.session.option import HasFeatures, OptionReader, Value

if TYPE_CHECKING:
    from pytest_hricdv.execution.case import CaseResult, RunSettings
    from pytest_hricdv.extra.engines.records import EngineDifference
    from pytest_hricdv.generate.concrete import ConcreteTest
    from pytest_hricdv.results.model import TestResult
    from pytest_hricdv.session.run_context import RunContext
    from pytest_hricdv.testbench import Testbench

BOTH = "both"
"""Of `--hri-engine`: each test runs on the testbench's first two engines, which check each other."""

_ON_SECOND: pytest.StashKey[RunSettings] = pytest.StashKey()


class EnginesFeature(Feature[str]):
    """Runs tests on the engine that was asked for, or on two; its setting is the name of one, `BOTH`, or empty."""

    name = "engines"
    options = (
        Value(
            "engine",
            "NAME|both",
            "the physics engine, of the testbench's engines (default: the first that is installed); both: each test "
            "runs on the first two, and a verdict that depends on the engine is no pass",
        ),
    )

    def read(self, reader: OptionReader) -> str:
        """What was asked for; whether the testbench has it is seen when there is one."""
        return reader.text("engine")

    def rerun_options(self, reader: OptionReader) -> Iterable[str]:
        """The engine, if the command line names one."""
        engine = reader.named("engine")
        return () if engine is None else (f"--hri-engine={engine}",)

    def fingerprint(self, options: HasFeatures) -> Mapping[str, str]:
        """Runs on another engine are other runs."""
        return {"--hri-engine": self.settings(options)}

    def configure(self, testbench: Testbench, options: HasFeatures) -> Testbench:
        """The testbench on the engine that was asked for; of both, on the first one."""
        asked = self.settings(options)
        if not asked:
            return testbench
        from pytest_hricdv.testbench import TestbenchError

        names = tuple(testbench.engines)
        if not names:
            expected = 'none: give it engines={"name": "module"}'
            raise TestbenchError(f"engine {asked!r}: testbench {testbench.name!r} has {expected}")
        choices = (*names, BOTH) if len(names) > 1 else names
        if asked not in choices:
            raise TestbenchError(f"engine {asked!r}: testbench {testbench.name!r} has {', '.join(choices)}")
        return dataclasses.replace(testbench, engine=asked if asked in names else names[0])

    def header(self, context: RunContext) -> Iterable[str]:
        """Which engine is used, where that was asked for, or where it is not the testbench's first one."""
        from pytest_hricdv.session.testbench_search import passed_over

        asked, testbench = self.settings(context.options), context.collection.testbench
        if asked == BOTH:
            yield visible(f"hri: each test on {testbench.engine} and on {_on_second(testbench).engine}")
            return
        missing = () if asked else passed_over(testbench)
        if asked or missing:
            are = "is" if len(missing) == 1 else "are"
            why = f" ({' and '.join(missing)} {are} not installed)" if missing else ""
            yield visible(f"hri: physics by {testbench.engine}{why}")

    def check(self, context: RunContext) -> None:
        """Whether both engines are there."""
        from pytest_hricdv.session.pytest_options import runs_tests

        if self.settings(context.options) != BOTH or not runs_tests(context.collection.config):
            return
        from pytest_hricdv.session.testbench_search import import_engine

        testbench = context.collection.testbench
        for on_one in (testbench, _on_second(testbench)):
            import_engine(on_one)

    def after_run(self, context: RunContext, test: ConcreteTest, run: CaseResult) -> CaseResult:
        """The run, beside that on the second engine where engines check each other."""
        if self.settings(context.options) != BOTH:
            return run
        from pytest_hricdv.execution.case import execute

        if _ON_SECOND not in context.stash:
            second = _on_second(context.collection.testbench)
            context.stash[_ON_SECOND] = dataclasses.replace(context.run_settings, testbench=second)
        return dataclasses.replace(run, beside=execute(context.stash[_ON_SECOND], test))

    def describe(self, context: RunContext, run: CaseResult, result: TestResult) -> TestResult:
        """The result, with how the run went on the second engine."""
        if run.beside is None:
            return result
        from pytest_hricdv.extra.engines.comparison import compare
        from pytest_hricdv.extra.engines.records import BESIDE

        return BESIDE.put(result, compare(run, run.beside, context.collection.testbench))

    def discrepancies(self, result: TestResult) -> tuple[EngineDifference, ...]:
        """What depends on the engine."""
        from pytest_hricdv.extra.engines.records import BESIDE

        beside = BESIDE.of(result)
        return () if beside is None else beside.differences


def _on_second(testbench: Testbench) -> Testbench:
    """The testbench with the engine that checks its first one."""
    return dataclasses.replace(testbench, engine=tuple(testbench.engines)[1])


FEATURE = EnginesFeature()
