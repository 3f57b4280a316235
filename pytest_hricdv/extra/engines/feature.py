"""`EnginesFeature`: the physics engine that runs the tests (`--hri-engine`), and the cross-check with a second one.

With `--hri-engine=both`, `TestRunner` lets the feature repeat each test on the second engine. `compare` finds the
differences, and a test whose verdict depends on the engine does not pass. The `EngineComparison` is the section
`CROSS_CHECK` of the test's result, which `EnginesView` shows.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Literal

import pytest
from msgspec import Struct

from pytest_hricdv._base.message import visible
from pytest_hricdv._base.record import Count, Names, Number, PlainRecord
from pytest_hricdv.results.section import TestSection
from pytest_hricdv.session.feature import Feature
from pytest_hricdv.session.option import HasFeatures, OptionReader, Value

if TYPE_CHECKING:
    from pytest_hricdv.execution.case import CaseResult, RunSettings
    from pytest_hricdv.generate.concrete import ConcreteTest
    from pytest_hricdv.monitor import Verdict
    from pytest_hricdv.results.model import TestResult
    from pytest_hricdv.session.run_context import RunContext
    from pytest_hricdv.testbench import Testbench


class OtherVerdict(PlainRecord, frozen=True, kw_only=True):
    """The verdict of a requirement on the second engine."""

    verdict: Literal["Passed", "Failed", "NC"]
    margin: Number | None
    triggers: Count


class EngineDifference(PlainRecord, frozen=True, kw_only=True):
    """A difference between engines: in a requirement, or in how the run or its interactions ended.

    Args:
        what: the name of the requirement, `end`, or what the testbench calls the interactions.
        text: the result on each engine, for the user.
        tolerated: whether margins differ by no more than the testbench allows engines to differ.
    """

    what: str
    text: str
    tolerated: bool


class EngineComparison(PlainRecord, frozen=True, kw_only=True):
    """The result of the same test on a second engine.

    Args:
        outcomes: how each interaction ended there, in order.
        requirements: requirement -> its result there.
        errors: errors of that run, a sentence each.
        differences: what depends on the engine.
    """

    engine: str
    outcomes: Names
    record_sha256: str
    requirements: Mapping[str, OtherVerdict]
    errors: Names
    differences: tuple[EngineDifference, ...]


CROSS_CHECK: TestSection[EngineComparison | None] = TestSection(
    "cross_check", EngineComparison | None, None, identifies=True
)
"""The result of the same test on a second engine, in a session in which engines check each other."""

TEST_SECTIONS = (CROSS_CHECK,)


def further_engines(test: Struct) -> Names:
    """The second engine of a test, if it ran on two."""
    second = CROSS_CHECK.of(test)
    return (second.engine,) if second is not None else ()


LOOK = "outcome differs: investigate"
TOLERATED = "within engine tolerance"
_WORDS = {"Passed": "passed", "Failed": "failed", "NC": "not checked"}


def compare(result: CaseResult, other: CaseResult, testbench: Testbench) -> EngineComparison:
    """Compare the results of a test on two engines.

    Args:
        result: the result on the first engine.
        other: the result of the same test on the second engine.
        testbench: declares by how much margins may differ.
    """
    differences = []
    if result.outcome.outcomes != other.outcome.outcomes:
        texts = (" ".join(run.outcome.outcomes) or "none" for run in (result, other))
        differences.append(_outcome_difference(testbench.outcome_label, result.engine, other.engine, *texts))
    if result.outcome.ended != other.outcome.ended:
        ends = result.outcome.ended, other.outcome.ended
        differences.append(_outcome_difference("end", result.engine, other.engine, *ends))
    for verdict, other_verdict in zip(result.verdicts, other.verdicts, strict=True):
        if verdict.verdict != other_verdict.verdict:
            tolerance = testbench.simulation.engine_tolerances.get(verdict.requirement)
            differences.append(_verdict_difference(verdict, other_verdict, result.engine, other.engine, tolerance))
    return EngineComparison(
        engine=other.engine,
        outcomes=tuple(other.outcome.outcomes),
        record_sha256=other.record.sha256,
        requirements={
            verdict.requirement: OtherVerdict(verdict=verdict.verdict, margin=verdict.margin, triggers=verdict.triggers)
            for verdict in other.verdicts
        },
        errors=other.errors,
        differences=tuple(differences),
    )


def _outcome_difference(name: str, engine: str, other_engine: str, outcome: str, other: str) -> EngineDifference:
    text = f"{name}: {outcome} on {engine}, {other} on {other_engine}: {LOOK}"
    return EngineDifference(what=name, text=text, tolerated=False)


def _verdict_difference(
    verdict: Verdict, other: Verdict, engine: str, other_engine: str, tolerance: float | None
) -> EngineDifference:
    tolerated = (
        tolerance is not None
        and verdict.margin is not None
        and other.margin is not None
        and abs(verdict.margin - other.margin) <= tolerance
    )
    texts = f"{_describe(verdict, engine)}, {_describe(other, other_engine)}"
    text = f"{verdict.requirement}: {texts}: {TOLERATED if tolerated else LOOK}"
    return EngineDifference(what=verdict.requirement, text=text, tolerated=tolerated)


def _describe(verdict: Verdict, engine: str) -> str:
    by = "" if verdict.margin is None else f" by {verdict.margin:+.4g}"
    return f"{_WORDS[verdict.verdict]} on {engine}{by}"


BOTH = "both"
"""A value of `--hri-engine`: each test runs on the testbench's first two engines, which check each other."""

_ON_SECOND: pytest.StashKey[RunSettings] = pytest.StashKey()


class EnginesFeature(Feature[str]):
    """Runs tests on the requested engine, or on two; its setting is the name of one, `BOTH`, or empty."""

    name = "engines"
    group = "tests"
    options = (
        Value(
            "engine",
            "NAME|both",
            "one of the testbench's physics engines (default: the first one installed); both: each test runs on the "
            "first two, and does not pass if its verdict depends on the engine",
        ),
    )

    def read(self, reader: OptionReader) -> str:
        """The requested engine; `configure` checks that the testbench has it."""
        return reader.text("engine")

    def rerun_options(self, reader: OptionReader) -> Iterable[str]:
        """The engine, if the command line names one."""
        engine = reader.command_line_value("engine")
        return () if engine is None else (f"--hri-engine={engine}",)

    def fingerprint(self, options: HasFeatures) -> Mapping[str, str]:
        """The engine, since runs differ between engines."""
        return {"--hri-engine": self.settings(options)}

    def configure(self, testbench: Testbench, options: HasFeatures) -> Testbench:
        """The testbench on the requested engine; on the first one if both are requested."""
        asked = self.settings(options)
        if not asked:
            return testbench
        from pytest_hricdv.testbench import TestbenchError

        names = tuple(testbench.simulation.engines)
        if not names:
            expected = 'none: give it simulation=Simulation(engines={"name": "module"})'
            raise TestbenchError(f"engine {asked!r}: testbench {testbench.name!r} has {expected}")
        choices = (*names, BOTH) if len(names) > 1 else names
        if asked not in choices:
            raise TestbenchError(f"engine {asked!r}: testbench {testbench.name!r} has {', '.join(choices)}")
        return testbench.choose(engine=asked if asked in names else names[0])

    def header(self, context: RunContext) -> Iterable[str]:
        """The engine in use, if it was requested or is not the testbench's first one."""
        from pytest_hricdv.session.testbench_search import engines_not_installed

        asked, testbench = self.settings(context.options), context.collection.testbench
        if asked == BOTH:
            yield visible(
                f"hri: each test on {testbench.simulation.engine} and on {_on_second(testbench).simulation.engine}"
            )
            return
        missing = () if asked else engines_not_installed(testbench)
        if asked or missing:
            are = "is" if len(missing) == 1 else "are"
            why = f" ({' and '.join(missing)} {are} not installed)" if missing else ""
            yield visible(f"hri: physics by {testbench.simulation.engine}{why}")

    def check(self, context: RunContext) -> None:
        """Check that both engines can be imported."""
        from pytest_hricdv.session.pytest_options import runs_tests

        if self.settings(context.options) != BOTH or not runs_tests(context.collection.config):
            return
        from pytest_hricdv.session.testbench_search import import_engine

        testbench = context.collection.testbench
        for on_one in (testbench, _on_second(testbench)):
            import_engine(on_one)

    def after_run(self, context: RunContext, test: ConcreteTest, run: CaseResult) -> CaseResult:
        """The run, along with that on the second engine if engines check each other."""
        if self.settings(context.options) != BOTH:
            return run
        from pytest_hricdv.execution.case import execute

        if _ON_SECOND not in context.stash:
            second = _on_second(context.collection.testbench)
            context.stash[_ON_SECOND] = dataclasses.replace(context.run_settings, testbench=second)
        return dataclasses.replace(run, cross_check=execute(context.stash[_ON_SECOND], test))

    def describe(self, context: RunContext, run: CaseResult, result: TestResult) -> TestResult:
        """The result, compared with that on the second engine."""
        if run.cross_check is None:
            return result
        return CROSS_CHECK.put(result, compare(run, run.cross_check, context.collection.testbench))

    def discrepancies(self, result: TestResult) -> tuple[EngineDifference, ...]:
        """The differences between engines."""
        second = CROSS_CHECK.of(result)
        return () if second is None else second.differences


def _on_second(testbench: Testbench) -> Testbench:
    """The testbench on its second engine, which checks the first one."""
    return testbench.choose(engine=tuple(testbench.simulation.engines)[1])


FEATURE = EnginesFeature()
