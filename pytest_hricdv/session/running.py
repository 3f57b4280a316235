"""`TestRunner`: executes and measures each generated test; `plugin` registers it in each process that runs tests."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator
from typing import TypedDict

import pytest
from msgspec.structs import replace

from pytest_hricdv._base.error_text import shorten
from pytest_hricdv._base.message import legible
from pytest_hricdv.coverage.measurement import Measurement, NoMeasurement
from pytest_hricdv.execution.case import CaseResult, execute
from pytest_hricdv.execution.faults import CodeUnderTest
from pytest_hricdv.execution.hri_case import HriCase
from pytest_hricdv.execution.judge import judge_run, judge_test
from pytest_hricdv.execution.outcome import XFAILED, Judgement
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.report import explanation, junit
from pytest_hricdv.report.run_lines import LogLine, RunLog
from pytest_hricdv.results.codec import encode_bounded
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.results.report_builder import build_result
from pytest_hricdv.run import UnstartableError
from pytest_hricdv.runtime import KernelError
from pytest_hricdv.runtime.node_error import word_of
from pytest_hricdv.session.collection import ATTRIBUTE, case_of
from pytest_hricdv.session.feature import features
from pytest_hricdv.session.following import IMPORTS
from pytest_hricdv.session.option import locate_error
from pytest_hricdv.session.pytest_options import (
    cut_texts,
    end_of,
    explain_failure,
    failure_text,
)
from pytest_hricdv.session.replaying import replay_mismatch
from pytest_hricdv.session.run_context import RunContext

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too

FAIL = pytest.fail  # as it is now: the code under test may replace it


class RerunInfo(TypedDict):
    """How a test can be run again, and what it logged."""

    seed: int
    suite: str
    rerun_options: tuple[str, ...]
    file: str
    logged: tuple[LogLine, ...]


class TestRunner:
    """Runs cases, measures them, and attaches one JSON text per test to pytest's report."""

    def __init__(self, context: RunContext) -> None:
        self.context = context
        self.collection = context.collection
        self.options = context.options
        self._used: Measurement = NoMeasurement("nothing has run")
        self._built: tuple[HriCase, CaseResult | None, TestResult] | None = None
        self._log = RunLog()
        """The log of the last run."""
        self._in_setup = False
        self._setup_s = 0.0
        """How long the setup of the present test took, where a fixture ran it."""

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        """Chooses the measurement before the first test: what takes long would count for its time-out."""
        if not session.config.getoption("collectonly") and any(map(case_of, session.items)):
            _ = self.context.measurement

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        """Releases the run after its test: pytest keeps all items to the end, and a run is large."""
        imports = item.config.stash.get(IMPORTS, None)
        if imports is not None:
            imports.begin()
        try:
            return (yield)
        finally:
            case = case_of(item)
            if case is not None:
                case.forget()

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> Iterator[None]:
        """Binds the runner: fixtures may run the test as well."""
        case = case_of(item)
        if case is not None:
            case.forget()  # of an earlier run of the same item, as pytest-rerunfailures makes them
            self._built = None  # of another test function with the same case
            self._setup_s, self._in_setup = 0.0, True
            case.runner = lambda this: self._run(this, item)
            case.checker = lambda this, result: self._check(this, result, item.nodeid)
        return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        """Requires a run and its check, and records JUnit properties."""
        case = case_of(item)
        self._in_setup = False
        if case is None or case.is_elsewhere:
            return (yield)
        try:
            yield
            self._require_check(case)
        finally:
            case.runner = case.checker = None
            result, label = self._result(case, item.nodeid), self.collection.testbench.outcome_label
            item.user_properties.extend(junit.junit_properties(result, label))

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_teardown(self, item: pytest.Item) -> Iterator[None]:
        """Unbinds the runner, also where there was no call."""
        case = case_of(item)
        if case is not None:
            case.runner = case.checker = None
        return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item: pytest.Item, call: pytest.CallInfo[None]) -> Iterator[None]:
        """Attaches the result to the report of the call: as a string, which xdist can send."""
        report: pytest.TestReport = yield  # type: ignore[assignment]
        case = case_of(item)
        if case is not None:
            cut_texts(report)
        skipped = report.skipped and not hasattr(report, "wasxfail")  # then it has no result: it was not run
        if case is not None and call.when == "setup" and case.result is not None:
            self._setup_s = call.duration  # a fixture ran the test
        is_over = case is not None and (call.when == "call" or _ends_in_setup(case, call))
        if case is not None and is_over and not (skipped or case.is_elsewhere):
            is_judged = call.excinfo is not None and call.excinfo.value is case.raised
            ending = case.judgement if is_judged else None
            outcome = judge_test(end_of(report), ending, has_run=case.result is not None)
            result = self._result(case, item.nodeid)
            failure = failure_text(report, call, outcome, ending)
            wall_s = call.duration + (self._setup_s if call.when == "call" else 0.0)
            result = replace(result, outcome=outcome, wall_s=wall_s, failure=failure)
            setattr(report, ATTRIBUTE, encode_bounded(self._finish(case, result, report)))
            self._built = None
        return report  # type: ignore[return-value]

    def _finish(self, case: HriCase, result: TestResult, report: pytest.TestReport) -> TestResult:
        """Let features complete the result. If the test's time limit ends meanwhile, only the test fails.

        pytest-timeout raises wherever the test is; raised from this hook, it would end the session.
        """
        finished = result
        try:
            for feature in features():
                finished = feature.after_test(self.context, case, finished, report)
        except FAIL.Exception as error:
            report.outcome, report.longrepr = "failed", f"{error}: while the result of the test was written, or filmed"
            return replace(result, outcome="failed", failure=report.longrepr)
        return finished

    def _run(self, case: HriCase, item: pytest.Item) -> CaseResult:
        nodeid, self._used = item.nodeid, self.context.measurement
        if self._in_setup and self.options.isolate:
            FAIL(
                "hri_case.run in a fixture: with --hri-isolate only the calls of tests are in processes of their own: "
                "run it in the test function",
                pytrace=False,
            )
        try:
            if self.options.stop_at:
                return self._run_to_breakpoint(case.concrete)
            settings = self.context.run_settings.with_measurement(self._used)
            with RunLog() as self._log:
                run = execute(settings, case.concrete, f"hricdv|{nodeid}", begun=self._begin)
            for feature in features():
                run = feature.after_run(self.context, case.concrete, run)
            return run
        except (Exception, SystemExit) as error:
            refuse_failed_import(error, item)
            refuse_missing_part(error, item)
            # The exception of the author's code, with its line, says more than that a node failed.
            cause = error.__cause__ if isinstance(error, KernelError) else None
            failure = error if cause is None or word_of(cause) else cause
            place = str(error) if isinstance(error, KernelError) else "the testbench's run failed"
        shown = self._result_to_show(case, nodeid)
        failure = shorten(failure)
        failure.add_note("\n" + explanation.describe_abort(shown, place, **self._rerun_info(case)))
        raise explain_failure(failure)

    def _begin(self, code: CodeUnderTest) -> None:
        """Log messages with simulated times from now on."""
        self._log.now_s = lambda: code.now_s

    def _run_to_breakpoint(self, test: ConcreteTest) -> CaseResult:
        """The result of a run; if it violates a requirement to stop at, a second run stops there in a debugger."""
        from pytest_hricdv.session.breaking import BreakpointRunner  # it loads pdb

        files = [file.path for file in self.context.code.files]
        settings = self.context.run_settings.with_measurement(self._used)
        return BreakpointRunner(self.options.stop_at, settings, files).run(test)

    def _require_check(self, case: HriCase) -> None:
        if case.raised is not None:
            raise case.raised  # the function has caught it, and would pass with what failed
        if case.result is None:
            FAIL("the test ended without a run: call hri_case.check(hri_case.run())", pytrace=False)
        if case.checked is not case.result:
            case.check(case.result)

    def _check(self, case: HriCase, result: CaseResult, nodeid: str) -> None:
        """Judges a run, and ends its test unless it passed."""
        built = self._result(case, nodeid)
        mismatch = replay_mismatch(built.replayed)
        differences = [difference for feature in features() for difference in feature.discrepancies(built)]
        judgement = judge_run(result, self.context.violation_exemptions, differences=differences, mismatch=mismatch)
        case.judgement = judgement

        def explain() -> str:
            shown = replace(self._result_to_show(case, nodeid), failure=mismatch)
            return explanation.failure(
                shown,
                self.context.texts,
                known_violations=self.context.violation_exemptions,
                units=self.collection.testbench.units,
                brief=self.collection.config.get_verbosity() <= 0,
                **self._rerun_info(case),
            )

        try:
            raise_for(judgement, result, explain)
        except BaseException as raised:
            case.raised = raised
            raise

    def _result_to_show(self, case: HriCase, nodeid: str) -> TestResult:
        return replace(self._result(case, nodeid), nodeid=self.context.show_nodeid(nodeid))

    def _rerun_info(self, case: HriCase) -> RerunInfo:
        replayed = self.collection.replays.get(case.abstract.id)
        file = replayed.name if replayed else self.context.failures.name(case.abstract.id)
        options = self.options
        return {
            "seed": options.seed,
            "suite": options.suites,
            "rerun_options": options.again,
            "file": file,
            "logged": self._log.lines,
        }

    def _result(self, case: HriCase, nodeid: str) -> TestResult:
        """The test's result, without what pytest says of it; built once for a run."""
        run = case.result
        if self._built is None or self._built[0] is not case or self._built[1] is not run:
            result = build_result(
                case,
                nodeid,
                run,
                code=self.context.code,
                requirements=self.context.requirements,
                unmeasured=why_unmeasured(run, self._used),
            )
            if run is not None:
                for feature in features():
                    result = feature.describe(self.context, run, result)
            file = self.collection.replays.get(case.abstract.id)
            if file is not None:
                result = replace(result, replay=file.name, replayed=self.context.provenance.compare(file, result))
            self._built = (case, run, result)
        return self._built[2]


def refuse_failed_import(error: BaseException, item: pytest.Item) -> None:
    """Ends the session, with one message, if the testbench's run needs a module that cannot be imported.

    Every other test would fail alike. In a node of the code under test, it is a failure of that run.
    """
    imports = item.config.stash.get(IMPORTS, None)
    failed = None if imports is None or isinstance(error, KernelError) else imports.watch.find_failure(error)
    if failed is None:
        return
    name, raised = failed
    message = legible(
        f"{locate_error(raised)}\nThe testbench's run needs {name}, which cannot be imported: install what it lacks, "
        "or let the conftest put a stand-in for that into sys.modules. No further test is run."
    )
    item.session.shouldfail = message.partition("\n")[0]
    FAIL(message, pytrace=False)


def refuse_missing_part(error: BaseException, item: pytest.Item) -> None:
    """Ends the session, with one message, if the code that the testbench's run starts does not exist."""
    if isinstance(error, UnstartableError):
        item.session.shouldfail = str(error)
        FAIL(f"{error}. No further test is run.", pytrace=False)


def why_unmeasured(run: CaseResult | None, measurement: Measurement) -> str:
    """Why the code under test was not measured in a run, or not completely; empty if it was."""
    if run is None or (run.code is not None and run.code.branches is not None):
        return ""
    if measurement.reason or run.has_measured_node:
        return measurement.reason
    return (
        "the testbench's run wraps no node with run.measured: spawn the node of the code under test as "
        'run.kernel.spawn("robot", run.measured(robot))'
    )


def raise_for(judgement: Judgement, result: CaseResult, explain: Callable[[], str]) -> None:
    """End a test as its run was judged; a passing test continues.

    Args:
        explain: makes the text that says why it failed.
    """
    if judgement.outcome in XFAILED:
        pytest.xfail(judgement.reason)  # with pytest's --runxfail this does nothing, and the test fails
    if judgement.outcome == "passed":
        return
    if judgement.depends_on_engine:
        FAIL(judgement.reason, pytrace=False)
    cause = result.error.__cause__ if result.error is not None else None
    if isinstance(cause, Exception) and not word_of(cause):  # with its line it says more than that a node failed
        shown = shorten(cause)
        shown.add_note("\n" + explain())
        raise explain_failure(shown)
    raise explain_failure(FAIL.Exception(explain(), pytrace=False))


def _ends_in_setup(case: HriCase, call: pytest.CallInfo[None]) -> bool:
    """Whether a fixture ran the test and then failed, so that there is no call: its run is a result as any."""
    return call.when == "setup" and call.excinfo is not None and case.result is not None
