"""Isolation (`--hri-isolate`): calls each generated test in a process of its own, forked from this one.

No run happens in this process, so each starts from the same state: modules, class attributes, caches and singletons
are those from before the first test. Fixtures are set up and torn down here, once for their scope, as in pytest.

`plugin` registers `Isolation` as the outermost plugin around a test's call. The fork runs the test, makes its report
with all that plugins attach, sends it as a `CallResult`, and ends. This process only waits for that message.

On a system without forks, a new process is started instead (`session.spawned`): it configures pytest and sets up the
test's fixtures again.
"""

from __future__ import annotations

import base64
import importlib
import os
import pickle
import sys
import warnings
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import pytest

from pytest_hricdv._base.error_text import text_of
from pytest_hricdv.coverage.measurement import OwnMeasurement
from pytest_hricdv.execution.execution_feature import execution_features
from pytest_hricdv.execution.forks import Fork, ForkError, InFork, fork
from pytest_hricdv.execution.run_monitors import formulas
from pytest_hricdv.execution.separate_process import ProcessError, start_process
from pytest_hricdv.monitor import MonitorSet
from pytest_hricdv.results.codec import decode
from pytest_hricdv.runtime.virtual.modules import STAND_INS
from pytest_hricdv.session.child_process import FreshSession, drop_editor_plugin, make_worker_input, session_arguments
from pytest_hricdv.session.collection import ATTRIBUTE, case_of, worker_input
from pytest_hricdv.session.feature import features
from pytest_hricdv.session.run_context import RunContext
from pytest_hricdv.session.testbench_search import engine_modules


@dataclass(frozen=True)
class CaughtWarning:
    """A warning of a test, issued again in the process where pytest counts warnings."""

    message: Warning | str
    category: type[Warning]
    filename: str
    lineno: int


@dataclass(frozen=True)
class CallResult:
    """The message that a process sends after the call of a test.

    Args:
        report: the report of the call, as pytest sends reports; None if there is none.
        sections: what the test has written, by phase and kind, for the report of its teardown.
        properties: the properties that the test has recorded.
        warned: its warnings.
        exit: the test has ended the session, with this text and status.
        problem: what went wrong besides the test: an error of a plugin.
    """

    report: dict[str, Any] | None = None
    sections: tuple[tuple[str, str, str], ...] = ()
    properties: tuple[tuple[str, object], ...] = ()
    warned: tuple[CaughtWarning, ...] = ()
    exit: tuple[str, int | None] | None = None
    problem: str = ""


def answer_of(item: pytest.Item, report: pytest.TestReport, caught: Iterable[warnings.WarningMessage]) -> CallResult:
    """The result of a call, as it is sent.

    Args:
        item: the item that was called.
        report: the report of the call, with all that plugins attach.
        caught: its warnings.
    """
    data = item.config.hook.pytest_report_to_serializable(config=item.config, report=report)
    return CallResult(
        report={key: value for key, value in data.items() if _can_be_sent(value)},
        sections=tuple(item._report_sections),
        properties=tuple(entry for entry in item.user_properties if _can_be_sent(entry)),
        warned=tuple(map(_warnings_of, caught)),
    )


def _warnings_of(caught: warnings.WarningMessage) -> CaughtWarning:
    message, category = caught.message, caught.category
    whole = _can_be_sent(message) and _can_be_sent(category)
    return CaughtWarning(
        message if whole else str(message), category if whole else UserWarning, caught.filename, caught.lineno
    )


def _can_be_sent(value: object) -> bool:
    """Whether a value can be pickled and unpickled."""
    try:
        pickle.loads(pickle.dumps(value))
    except Exception:
        return False
    return True


__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too


@dataclass
class _Call:
    """The call of a test, as this process sees it, which does not make it.

    Args:
        answer: the process's answer; None if it ended without one.
        report: the report of the answer.
        problem: how it ended.
    """

    answer: CallResult | None = None
    report: pytest.TestReport | None = None
    problem: str = ""


_SPAWNED = "pytest_hricdv.session.spawned"
_ARGUMENTS = "hricdv_arguments"
"""Key in an xdist worker's input for the session's arguments, which differ from the worker's own."""


class Isolation:
    """Makes the call of each generated test in a process. Registered where tests run, last of the plugin's objects."""

    def __init__(self, context: RunContext) -> None:
        self._context = context
        self._forks = hasattr(os, "fork")
        self._environment, self._path = dict(os.environ), tuple(sys.path)  # before a test can change them
        self._is_prepared = False
        self._in_fork: InFork | None = None
        self._caught: list[warnings.WarningMessage] = []
        self._call: _Call | None = None

    def pytest_sessionstart(self) -> None:
        """Warns of what a process that is started does not do."""
        config = self._context.collection.config
        if self._forks or not config.getoption("cov_source", None) or worker_input(config) is not None:
            return
        text = "--cov does not count what --hri-isolate runs: this system has no forks; the report's own coverage does"
        self._context.collection.warn(text, str(config.inipath or config.rootpath), 1)

    @pytest.hookimpl(optionalhook=True)
    def pytest_configure_node(self, node: object) -> None:
        """xdist: a worker can start processes like those of the session."""
        values: dict[str, object] = node.workerinput  # type: ignore[attr-defined]
        values[_ARGUMENTS] = list(session_arguments(self._context.collection.config))

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self) -> Iterator[None]:
        """The fork goes no further than its test, whatever becomes of its report: it would be a second session."""
        try:
            return (yield)
        finally:
            if self._in_fork is not None:
                self._send(self._in_fork, CallResult(problem="it could not report its end"))

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        """Forks, or starts a process, before anything is called."""
        if case_of(item) is None or self._context.debugger_reason:
            return (yield)
        if not self._forks:
            self._call = self._spawn(item)
            yield from self._call_elsewhere(item, self._call)
            return None
        self._prepare()
        process = fork()
        if isinstance(process, InFork):
            self._in_fork = process
            return (yield from self._call_in_fork(process))
        self._call = self._await_answer(process, item)
        yield from self._call_elsewhere(item, self._call)

    def _call_in_fork(self, process: InFork) -> Iterator[None]:
        try:
            with warnings.catch_warnings(record=True) as self._caught:
                return (yield)
        except pytest.exit.Exception as ended:
            self._send(process, CallResult(exit=(ended.msg, ended.returncode)))
        except KeyboardInterrupt:
            self._send(process, CallResult(problem="interrupted"))

    def _call_elsewhere(self, item: pytest.Item, call: _Call) -> Iterator[None]:
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
        plugins = (module for feature in execution_features() for module in feature.preloaded)
        for name in (*testbench.simulation.requires, *engine_modules(testbench), *STAND_INS, *plugins):
            importlib.import_module(name)
        if isinstance(context.measurement, OwnMeasurement):
            context.measurement.begin()
        MonitorSet(formulas(context.requirements))  # compiles them

    def _await_answer(self, process: Fork, item: pytest.Item) -> _Call:
        """The answer of a fork."""
        try:
            return self._take(pickle.loads(process.message()), item)
        except ForkError as error:
            return _Call(problem=f"{item.nodeid}: its process {error}, without a result; see what it wrote last")
        finally:
            process.close()

    def _spawn(self, item: pytest.Item) -> _Call:
        """The answer of a process that is started for this test."""
        collection = self._context.collection
        config = collection.config
        sent: dict[str, Any] | None = worker_input(config)
        arguments = session_arguments(config) if sent is None else sent[_ARGUMENTS]
        values = make_worker_input(config, collection.worker_values()) if sent is None else sent
        session = FreshSession(drop_editor_plugin(arguments), dict(values), (item.nodeid,))
        directory = config.invocation_params.dir
        with start_process(_SPAWNED, directory, path=self._path, inherited=self._environment) as process:
            process.send(session)
            try:
                lines = [*process.answer()]
            except ProcessError as error:
                return _Call(problem=f"{item.nodeid}: its process gave no result: {error}")
        return self._take(pickle.loads(base64.b64decode(lines[0])), item)

    def _take(self, answer: CallResult, item: pytest.Item) -> _Call:
        if answer.problem:
            return _Call(problem=f"{item.nodeid}: in its process: {answer.problem}")
        if answer.report is None:
            return _Call(answer)
        taken = item.config.hook.pytest_report_from_serializable
        return _Call(answer, taken(config=item.config, data=answer.report))

    @pytest.hookimpl(tryfirst=True)
    def pytest_pyfunc_call(self) -> bool | None:
        """Ends the test here as it ended there, for plugins that look at exceptions."""
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
                answer = answer_of(item, made, self._caught)
            except BaseException as error:
                answer = CallResult(problem=f"{type(error).__name__}: {text_of(error)}")
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

    def _send(self, process: InFork, answer: CallResult) -> None:
        _keep_coverage()
        process.send_and_end(pickle.dumps(answer))

    def _note(self, report: pytest.TestReport) -> None:
        text = getattr(report, ATTRIBUTE, None)
        if isinstance(text, str):
            result = decode(text)
            for feature in features():
                feature.after_isolated_test(self._context, result)


def _keep_coverage() -> None:
    """Write what the user's own measurement (`--cov`) has of this process, into a file of its own."""
    control = sys.modules.get("coverage")
    current = control.Coverage.current() if control is not None else None
    if current is not None:
        current.stop()
        current.save()
