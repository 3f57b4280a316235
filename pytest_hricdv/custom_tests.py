"""`HriRun`: the value of the fixture `hri_run` (`plugin`), by which tests written by hand run an abstract test."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import pytest

from pytest_hricdv._base.message import nearest
from pytest_hricdv.execution.case import CaseResult, execute
from pytest_hricdv.execution.hri_case import HriCase
from pytest_hricdv.execution.judge import judge_run
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest, abstract_from, concretize
from pytest_hricdv.generate.suite_files import parse_tests
from pytest_hricdv.report import explanation
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.results.report_builder import build_result
from pytest_hricdv.session.collection import Collection
from pytest_hricdv.session.options import read_options
from pytest_hricdv.session.pytest_options import FirstLines
from pytest_hricdv.session.run_context import CONTEXT, RunContext
from pytest_hricdv.session.running import raise_for
from pytest_hricdv.testbench import TestbenchError

if TYPE_CHECKING:
    from pytest_hricdv.generate.concrete import Concretization

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too

__all__ = ["CaseResult", "HriCase", "HriRun"]

SUITE = "handmade"
"""The name of the suite in ids and results of tests that are run by `hri_run`."""


class HriRun:
    """The value of the fixture `hri_run`.

    >>> def test_a_leg_is_handed_over(hri_run):     # doctest: +SKIP
    ...     result = hri_run('''
    ...         tell leg
    ...         set_param gaze = 1
    ...     ''', sensing_timeout_s=12.0)
    ...     assert result.verdict("R4").verdict == "Passed"

    No suite needs to be active. Its runs are not in the report, and their coverage is measured by `--cov` only.
    """

    def __init__(self, context: RunContext, item: pytest.Item) -> None:
        self._context = context
        self._item = item
        self._results: list[tuple[CaseResult, TestResult]] = []

    def __call__(
        self, test: str | Iterable[str] | ConcreteTest, /, *, seed: int = 0, **parameters: float
    ) -> CaseResult:
        """Run one test in the simulated world, watched by the monitors. It may be called several times.

        Args:
            test: the commands, one a line or one an item; or a concrete test, which is run as it is.
            seed: parameters that are not given are drawn from their declared ranges with it.
            parameters: values for parameters by their declared names, outside of their ranges, too; each holds for
                every command that has it, and for the run.

        Returns:
            Verdicts (`.verdict("R1")`, `.failed`), outcome, record, and simulated seconds. Nothing is
            checked: use `assert`, or give the result to `check`.

        Raises:
            GenerateError: a command or a parameter that the testbench does not declare, or a value that is not a
                number.
            NodeError: a node failed; the message names it and the simulated time.
        """
        try:
            case = self._case(test, seed, parameters)
        except GenerateError as error:
            raise GenerateError(str(error)) from None  # raised here, so that only the author's line is shown
        result = execute(self._context.run_settings, case.concrete)
        nodeid = self._context.show_nodeid(self._item.nodeid)
        built = build_result(case, nodeid, result, requirements=self._context.requirements)
        self._results.append((result, built))
        # pytest shows sections of tests that fail, for whatever reason.
        self._item.add_report_section("call", "hri_run", explanation.course(built))
        if result.error is not None:
            raise result.error  # it must not pass unnoticed where nothing is checked
        return result

    def check(self, result: CaseResult) -> None:
        """Fail, with an explanation, for violations that are not known, and for faults."""
        built = next((built for returned, built in self._results if returned is result), None)
        if built is None:
            raise ValueError(f"hri_run.check: expected what hri_run returned in this test, got {result!r:.60}")
        context, units = self._context, self._context.collection.testbench.units
        raise_for(
            judge_run(result, context.violation_exemptions),
            result,
            lambda: explanation.failure(
                built,
                context.texts,
                seed=None,
                known_violations=context.violation_exemptions,
                units=units,
                brief=self._item.config.get_verbosity() <= 0,
            ),
        )

    def __repr__(self) -> str:
        return "<hri_run>"

    def _case(self, test: str | Iterable[str] | ConcreteTest, seed: int, parameters: Mapping[str, float]) -> HriCase:
        ranges = self._context.collection.testbench.commands
        if isinstance(test, ConcreteTest):
            concrete = _with(test, parameters, ranges)
            return HriCase(test.suite, abstract_from(concrete, "given", keeps_id=True), ranges, fixed=concrete)
        abstract = _parse(test, seed, ranges)
        return HriCase(SUITE, abstract, ranges, fixed=_with(concretize(abstract, ranges), parameters, ranges))


def hri_run(request: pytest.FixtureRequest) -> HriRun:
    """The fixture's value. A testbench that is missing or wrong fails the test with one located message."""
    config = request.config
    if not config.pluginmanager.hasplugin(FirstLines.NAME):  # no suite is active
        config.pluginmanager.register(FirstLines(), FirstLines.NAME)
    try:
        if CONTEXT not in config.stash:
            config.stash[CONTEXT] = RunContext(Collection(config, read_options(config)))
        context = config.stash[CONTEXT]
        _ = context.run_settings
    except (pytest.UsageError, TestbenchError) as error:
        pytest.fail(f"hri_run: {error}", pytrace=False)
    return HriRun(context, request.node)


def _parse(test: str | Iterable[str], seed: int, ranges: Concretization) -> AbstractTest:
    text = test if isinstance(test, str) else "\n".join(test)
    tests = parse_tests(text, file="hri_run", suite=SUITE, master_seed=seed, commands=tuple(ranges.commands))
    if len(tests) != 1:
        raise GenerateError(
            f"hri_run: {len(tests)} tests in the text; expected one: commands on lines of their own, no blank line "
            "between them"
        )
    return tests[0]


def _with(test: ConcreteTest, parameters: Mapping[str, float], ranges: Concretization) -> ConcreteTest:
    """The test with these values for its parameters."""
    there = set(test.run).union(*(action.parameters for action in test.actions))
    for name, value in parameters.items():
        if name not in there:
            declared = set(ranges.run).union(*ranges.commands.values())
            why = "none of these commands has it" if name in declared else "the testbench declares none such"
            names = ", ".join(sorted(there)) or "none"
            raise GenerateError(f"hri_run: parameter {name!r}: {why}{nearest(name, there)}; there are: {names}")
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise GenerateError(f"hri_run: parameter {name!r} is {value!r}; expected a finite number")
    actions = tuple(ConcreteAction(action.command, _replace(action.parameters, parameters)) for action in test.actions)
    return replace(test, actions=actions, run=_replace(test.run, parameters))


def _replace(declared: Mapping[str, float], parameters: Mapping[str, float]) -> dict[str, float]:
    return {name: float(parameters.get(name, value)) for name, value in declared.items()}
