"""Isolation: the call of each generated test happens in a process of its own, forked from this one.

So no run happens in this process, and each begins from the state before the first one: lists of modules, attributes of
classes, caches, singletons and imports are what they were. Fixtures are set up and torn down here, once for their
scope, as pytest does.

The fork returns from the hook as if it were the only process: it runs the test, and makes its report, with all that
plugins attach. This it sends, and ends. Here, in the meantime, nothing is called; then its report is taken.
"""

from __future__ import annotations

import importlib
import os
import pickle
import sys
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import pytest

from pytest_hricdv.coverage.measurement import OwnMeasurement
from pytest_hricdv.execution.case import formulas
from pytest_hricdv.execution.execution_part import execution_parts
from pytest_hricdv.execution.forked import Fork, ForkError, InFork, fork
from pytest_hricdv.monitor import MonitorSet
from pytest_hricdv.results.codec import decode
from pytest_hricdv.runtime.virtual.modules import STAND_INS
from pytest_hricdv.session.collection import ATTRIBUTE, case_of
from pytest_hricdv.session.part import parts
from pytest_hricdv.session.run_context import RunContext
from pytest_hricdv.session.usage import usage_error

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too


@dataclass(frozen=True)
class Warned:
    """A warning of a test: it is given again where pytest counts warnings."""

    message: Warning | str
    category: type[Warning]
    filename: str
    lineno: int


@dataclass(frozen=True)
class Answer:
    """What a fork sends.

    Args:
        report: of the call, as pytest sends reports; None where there is none.
        sections: what the test has written, by phase and kind, for the report of its teardown.
        properties: that the test has recorded.
        warned: its warnings.
        exit: the test has ended the session, with this text and status.
        problem: what went wrong beside the test: an error of a plugin.
    """

    report: dict[str, Any] | None = None
    sections: tuple[tuple[str, str, str], ...] = ()
    properties: tuple[tuple[str, object], ...] = ()
    warned: tuple[Warned, ...] = ()
    exit: tuple[str, int | None] | None = None
    problem: str = ""


@dataclass
class _Call:
    """The call of a test, as this process sees it, which does not make it.

    Args:
        answer: of the fork; None where it ended without one.
        report: of the answer.
        problem: how it ended.
    """

    answer: Answer | None = None
    report: pytest.TestReport | None = None
    problem: str = ""


class Isolation:
    """Forks a process for the call of each generated test. Registered where tests run, last of the plugin's objects.

    Args:
        context: of the session.

    Raises:
        pytest.UsageError: this system cannot fork.
    """

    def __init__(self, context: RunContext) -> None:
        if not hasattr(os, "fork"):
            raise usage_error("--hri-isolate: this system cannot fork processes; use Linux or macOS")
        self._context = context
        self._is_prepared = False
        self._in_fork: InFork | None = None
        self._caught: list[warnings.WarningMessage] = []
        self._call: _Call | None = None

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        """Forks before anything is called."""
        if case_of(item) is None or self._context.debugged:
            return (yield)
        self._prepare()
        process = fork()
        if isinstance(process, InFork):
            self._in_fork = process
            return (yield from self._called_in_fork(process))
        self._call = self._awaited(process, item)
        yield from self._called_elsewhere(item, self._call)

    def _called_in_fork(self, process: InFork) -> Iterator[None]:
        try:
            with warnings.catch_warnings(record=True) as self._caught:
                return (yield)
        except pytest.exit.Exception as ended:
            self._send(process, Answer(exit=(ended.msg, ended.returncode)))
        except KeyboardInterrupt:
            self._send(process, Answer(problem="interrupted"))

    def _called_elsewhere(self, item: pytest.Item, call: _Call) -> Iterator[None]:
        case = case_of(item)
        assert case is not None, "only generated tests are isolated"
        case.is_elsewhere = call.answer is not None
        try:
            yield
        finally:
            if call.answer is not None:
                item._report_sections[:] = call.answer.sections
                item.user_properties[:] = call.answer.properties
                for warned in call.answer.warned:
                    warnings.warn_explicit(warned.message, warned.category, warned.filename, warned.lineno)

    def _prepare(self) -> None:
        """Once, and not in each fork: what is computed for all runs, and what the world is known to import."""
        if self._is_prepared:
            return
        self._is_prepared = True
        context, testbench = self._context, self._context.collection.testbench
        _ = context.run_settings, context.measurement, context.provenance, context.texts
        engine = [testbench.engines[testbench.engine]] if testbench.engine else []
        plugins = (module for part in execution_parts() for module in part.preloaded)
        for name in (*testbench.requires, *engine, *STAND_INS, *plugins):
            importlib.import_module(name)
        if isinstance(context.measurement, OwnMeasurement):
            context.measurement.begin()
        MonitorSet(formulas(context.requirements))  # compiles them

    def _awaited(self, process: Fork, item: pytest.Item) -> _Call:
        """The answer of a fork."""
        try:
            answer: Answer = pickle.loads(process.message())
        except ForkError as error:
            return _Call(problem=f"{item.nodeid}: its process {error}, without a result; see what it wrote last")
        finally:
            process.close()
        if answer.problem:
            return _Call(problem=f"{item.nodeid}: in its process: {answer.problem}")
        if answer.report is None:
            return _Call(answer)
        taken = item.config.hook.pytest_report_from_serializable
        return _Call(answer, taken(config=item.config, data=answer.report))

    @pytest.hookimpl(tryfirst=True)
    def pytest_pyfunc_call(self) -> bool | None:
        """Ends the test here as it ended in the fork, for plugins that look at exceptions."""
        call = self._call
        if call is None:
            return None
        if call.problem:
            pytest.fail(call.problem, pytrace=False)
        assert call.answer is not None, "there is one, or a problem"
        if call.answer.exit is not None:
            pytest.exit(*call.answer.exit)
        assert call.report is not None, "it is there unless the session ends"
        if call.report.failed:
            pytest.fail(call.report.longreprtext, pytrace=False)
        if call.report.skipped:
            pytest.skip("as in its own process")
        return True

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_makereport(self, item: pytest.Item) -> Iterator[None]:
        """In the fork, sends the report, and ends; here, takes it in place of what else was made."""
        if self._in_fork is not None:
            try:
                made: pytest.TestReport = yield  # type: ignore[assignment]
                answer = self._answer(item, made)
            except BaseException as error:
                answer = Answer(problem=f"{type(error).__name__}: {error}")
            self._send(self._in_fork, answer)
        report: pytest.TestReport = yield  # type: ignore[assignment]
        isolated, self._call = self._call, None
        if isolated is None or isolated.report is None:
            return report  # type: ignore[return-value]
        case = case_of(item)
        if case is not None:
            case.is_elsewhere = False
        for name, value in vars(report).items():
            vars(isolated.report).setdefault(name, value)  # what could not be sent
        self._note(isolated.report)
        return isolated.report  # type: ignore[return-value]

    def _answer(self, item: pytest.Item, report: pytest.TestReport) -> Answer:
        data = item.config.hook.pytest_report_to_serializable(config=item.config, report=report)
        return Answer(
            report={key: value for key, value in data.items() if _can_be_sent(value)},
            sections=tuple(item._report_sections),
            properties=tuple(entry for entry in item.user_properties if _can_be_sent(entry)),
            warned=tuple(map(_warned, self._caught)),
        )

    def _send(self, process: InFork, answer: Answer) -> None:
        _keep_coverage()
        process.send_and_end(pickle.dumps(answer))

    def _note(self, report: pytest.TestReport) -> None:
        text = getattr(report, ATTRIBUTE, None)
        if isinstance(text, str):
            result = decode(text)
            for part in parts():
                part.ran_elsewhere(self._context, result)


def _warned(caught: warnings.WarningMessage) -> Warned:
    message, category = caught.message, caught.category
    whole = _can_be_sent(message) and _can_be_sent(category)
    return Warned(
        message if whole else str(message), category if whole else UserWarning, caught.filename, caught.lineno
    )


def _can_be_sent(value: object) -> bool:
    """Whether it is the same on the other side of a pipe."""
    try:
        pickle.loads(pickle.dumps(value))
    except Exception:
        return False
    return True


def _keep_coverage() -> None:
    """Write what the user's own measurement (`--cov`) has of this process, into a file of its own."""
    control = sys.modules.get("coverage")
    current = control.Coverage.current() if control is not None else None
    if current is not None:
        current.stop()
        current.save()
