"""Running: executes and measures each generated test. Registered where tests run: in workers, or without xdist."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Generator, Iterable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TypedDict

import pytest
from msgspec.structs import replace

from pytest_hricdv.case import CaseResult, HriCase, Watcher, execute, oracles
from pytest_hricdv.coverage.code_map import CodeMap, CoverageError, map_code
from pytest_hricdv.coverage.measurement import Measurement, NoMeasurement, choose, debugger
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor import (
    Criterion,
    FormulaSource,
    PastFormula,
    RequirementError,
    load_definitions,
    load_requirements,
    parse_condition,
)
from pytest_hricdv.report import ci_formats, explanation
from pytest_hricdv.results.building import build_result, requirement_texts
from pytest_hricdv.results.codec import encode
from pytest_hricdv.results.engine_comparison import compare
from pytest_hricdv.results.model import RequirementText, TestOutcome, TestResult
from pytest_hricdv.results.plan import PlanPart
from pytest_hricdv.run import Actions
from pytest_hricdv.runtime import KernelError
from pytest_hricdv.session.collection import Collection, case_of
from pytest_hricdv.session.engine_verdict import ENGINE_SENSITIVE, judge_engines, unknown_on_any
from pytest_hricdv.session.films import Filming, film_text
from pytest_hricdv.session.plan_file import Known, PlanError, load_plan
from pytest_hricdv.session.replaying import Failures, Provenance, replay_mismatch
from pytest_hricdv.session.tracing import Tracing
from pytest_hricdv.session.usage import usage_error
from pytest_hricdv.testbench import ConformanceError

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too

ATTRIBUTE = "hricdv"
ELSEWHERE = NoMeasurement("it is measured on the first engine")


class RerunInfo(TypedDict):
    """How a test can be run again."""

    seed: int
    suite: str
    rerun_options: tuple[str, ...]
    file: str


class Running:
    """Runs cases, measures them, and attaches one JSON text per test to pytest's report."""

    def __init__(self, collection: Collection) -> None:
        self.collection = collection
        self.options = collection.options
        self._used: Measurement = NoMeasurement("nothing has run")
        self._built: tuple[HriCase, CaseResult | None, TestResult] | None = None

    @cached_property
    def requirements(self) -> tuple[Criterion, ...]:
        """What runs are judged by: the testbench's requirements, then its model, if runs are compared with one.

        Raises pytest.UsageError, located, when a text does not parse, or a correspondence names what does not exist.
        """
        testbench = self.collection.testbench
        try:
            requirements = load_requirements(testbench.requirements, testbench.vocabulary())
            found: tuple[Criterion, ...] = (*requirements, *oracles(testbench))
        except (RequirementError, ConformanceError, ValueError) as error:
            raise usage_error(str(error)) from None
        names = [each.id for each in found]
        for name in self.options.stop_at:
            if name not in names:
                raise usage_error(f"--hri-break={name}: no such requirement; there are: {', '.join(names)}")
        return found

    @cached_property
    def plan(self) -> tuple[PlanPart, ...]:
        """The parts of the verification plan, if there is one. Raises pytest.UsageError, located, for a wrong one."""
        if self.options.plan is None:
            return ()
        testbench = self.collection.testbench
        known = Known([each.id for each in self.requirements], testbench.cross, testbench.model.covered)
        try:
            return load_plan(self.options.plan, known)
        except PlanError as error:
            raise usage_error(f"--hri-plan: {error}") from None

    @property
    def known(self) -> Mapping[str, str]:
        """Requirements with a known violation, with the reasons; none in a strict run."""
        return {} if self.options.strict else {name: each.text for name, each in self.options.known.items()}

    @cached_property
    def known_while(self) -> Mapping[str, PastFormula]:
        """Requirement -> condition under which its violation is known, where there is one; none in a strict run.

        Conditions may use the definitions of the requirements' file.

        Raises:
            pytest.UsageError: a condition that does not parse, or names what the testbench does not declare.
        """
        testbench, parsed = self.collection.testbench, {}
        try:
            vocabulary = load_definitions(testbench.requirements, testbench.vocabulary())
            for name, known in self.options.known.items():
                if known.condition:
                    source = FormulaSource(known.condition, owner=f"known violation of {name}: condition")
                    parsed[name] = parse_condition(known.condition, vocabulary, source)
        except RequirementError as error:
            raise usage_error(str(error)) from None
        return {} if self.options.strict else parsed

    @property
    def texts(self) -> dict[str, RequirementText]:
        """Requirement -> its texts for people."""
        return requirement_texts(self.requirements)

    @cached_property
    def code(self) -> CodeMap:
        """What can be covered. Raises pytest.UsageError for code that is not there or a waiver without reason."""
        try:
            return map_code(self.collection.testbench.code, Path(self.collection.config.rootpath))
        except CoverageError as error:
            raise usage_error(str(error)) from None

    @property
    def measurement(self) -> Measurement:
        """How the code under test is measured now. A debugger, which can attach at any time, disables it."""
        if not self.options.coverage:
            return NoMeasurement("switched off with --hri-no-cov")
        stepping = self._stepping() or debugger()
        return NoMeasurement(stepping) if stepping else self._chosen

    def _stepping(self) -> str:
        if self.options.stop_at:
            return "--hri-break was given: measuring would get in its way"
        given = self.collection.config.option
        asked = [name for name, use in (("--pdb", "usepdb"), ("--trace", "trace")) if getattr(given, use, False)]
        return f"{asked[0]} was given: measuring would get in its way" if asked else ""

    @cached_property
    def _chosen(self) -> Measurement:
        by_test = getattr(self.collection.config.option, "cov_context", None) == "test"
        return choose(self.code, contexts_by_test=by_test)

    @cached_property
    def provenance(self) -> Provenance:
        """What the runs of this process depend on."""
        return Provenance.now(self.code, self.collection.testbench)

    @cached_property
    def failures(self) -> Failures:
        """Writes the replay files of failing tests."""
        return Failures(self.options.report, self.collection.config.invocation_params.dir)

    @cached_property
    def filming(self) -> Filming | None:
        """Films failing tests of this process; None without --hri-film."""
        if not self.options.film:
            return None
        return Filming(self.collection.testbench, self.requirements, self.options.report)

    @cached_property
    def tracing(self) -> Tracing | None:
        """Writes runs of this process as MCAP files; None without --hri-mcap."""
        asked = self.options.mcap
        if not asked:
            return None
        return Tracing(self.collection.testbench, self.requirements, self.options.report, every=asked == "all")

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        """Releases the run after its test: pytest keeps all items to the end, and a run is large."""
        try:
            return (yield)
        finally:
            case = case_of(item)
            if case is not None:
                case.forget()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        """Binds the runner for the call phase and records JUnit properties."""
        case = case_of(item)
        if case is None:
            return (yield)
        case.result, case.checked = None, False
        case.runner = lambda this: self._run(this, item.nodeid)
        case.judge = lambda this, result: self._judge(this, result, item.nodeid)
        try:
            yield
            self._require_check(case)
        finally:
            case.runner = case.judge = None
            result, label = self._result(case, item.nodeid), self.collection.testbench.outcome_label
            item.user_properties.extend(ci_formats.junit_properties(result, label))

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item: pytest.Item, call: pytest.CallInfo[None]) -> Iterator[None]:
        """Attaches the result to the report of the call: as a string, which xdist can send."""
        report: pytest.TestReport = yield  # type: ignore[assignment]
        case = case_of(item)
        skipped = report.skipped and not hasattr(report, "wasxfail")  # then it has no result: it was not run
        if case is not None and call.when == "call" and not skipped:
            outcome = _outcome(report, case)
            result = replace(
                self._result(case, item.nodeid), outcome=outcome, wall_s=call.duration, failure=_text(report)
            )
            setattr(report, ATTRIBUTE, encode(self._traced(case, self._filmed(case, result, report))))
            self._built = None
        return report  # type: ignore[return-value]

    def _filmed(self, case: HriCase, result: TestResult, report: pytest.TestReport) -> TestResult:
        """The result with its film, if the test failed: its duration is taken already, its patches still hold."""
        if self.filming is None or case.result is None or result.outcome not in ("failed", "known-violation"):
            return result
        film = self.filming.film(case.result)
        folder = os.path.relpath(self.options.report, self.collection.config.invocation_params.dir)
        report.sections.append(("film", film_text(film, Path(folder))))
        return replace(result, film=film)

    def _traced(self, case: HriCase, result: TestResult) -> TestResult:
        """The result with its MCAP file, if there is to be one."""
        if self.tracing is None or case.result is None:
            return result
        return replace(result, trace=self.tracing.trace(case.result, result))

    def execute(
        self,
        test: ConcreteTest,
        measurement: Measurement,
        context: str,
        producing: Actions | None = None,
        watching: Iterable[Watcher] = (),
    ) -> CaseResult:
        """Run a test as the session judges it; see `pytest_hricdv.case.execute`."""
        bench, known_while = self.collection.testbench, self.known_while
        return execute(bench, self.requirements, test, measurement, context, None, known_while, producing, watching)

    def _checked(self, test: ConcreteTest, result: CaseResult) -> CaseResult:
        """The result, beside that on the second engine where engines check each other."""
        second, known_while = self.collection.second_testbench, self.known_while
        if second is None:
            return result
        beside = execute(second, self.requirements, test, ELSEWHERE, "engine", known_while=known_while)
        return dataclasses.replace(result, beside=beside)

    def _run(self, case: HriCase, nodeid: str) -> CaseResult:
        self._used = self.measurement
        try:
            if self.options.stop_at:
                return self._stopped(case.concrete)
            return self._checked(case.concrete, self.execute(case.concrete, self._used, f"hricdv|{nodeid}"))
        except Exception as error:
            # The exception of the author's code, with its line, says more than that a node failed.
            failure = error.__cause__ if isinstance(error, KernelError) and error.__cause__ else error
            what = str(error) if isinstance(error, KernelError) else "the testbench's run failed"
        shown = self._shown_result(case, nodeid)
        failure.add_note("\n" + explanation.aborted(shown, what, **self._rerun_info(case)))
        raise failure

    def _stopped(self, test: ConcreteTest) -> CaseResult:
        """The result of a run; where it violates what was asked for, another one stops there."""
        from pytest_hricdv.session.breaking import Breaking  # it loads pdb

        files = [file.path for file in self.code.files]
        breaking = Breaking(self.options.stop_at, self.collection.testbench, self.requirements, files)
        return breaking.run(test, self._used, self.known_while)

    def _require_check(self, case: HriCase) -> None:
        if case.result is None:
            pytest.fail("the test ended without a run: call hri_case.check(hri_case.run())", pytrace=False)
        if not case.checked:
            case.check(case.result)

    def _judge(self, case: HriCase, result: CaseResult, nodeid: str) -> None:
        failed, known = result.failed, self.known
        built = self._result(case, nodeid)
        mismatch = replay_mismatch(built.replayed)
        if built.beside is not None and not (mismatch or result.faults):
            judge_engines(result, built.beside, known)
        if not (failed or mismatch or result.faults):
            return
        if not (unknown_on_any(result, known) or mismatch or result.faults):
            pytest.xfail(tolerated(failed, known))
        shown = replace(self._shown_result(case, nodeid), failure=mismatch)
        texts, units = self.texts, self.collection.testbench.units
        text = explanation.failure(shown, texts, known=known, units=units, **self._rerun_info(case))
        raised = result.error.__cause__ if result.error is not None else None
        if isinstance(raised, Exception):  # with its line it says more than that a node failed
            raised.add_note("\n" + text)
            raise raised
        pytest.fail(text, pytrace=False)

    def _shown_result(self, case: HriCase, nodeid: str) -> TestResult:
        return replace(self._result(case, nodeid), nodeid=self.shown(nodeid))

    def shown(self, nodeid: str) -> str:
        """The node id relative to the folder where pytest was started."""
        config = self.collection.config
        path, colons, rest = nodeid.partition("::")
        return os.path.relpath(config.rootpath / path, config.invocation_params.dir) + colons + rest

    def _rerun_info(self, case: HriCase) -> RerunInfo:
        given = self.collection.replays.get(case.abstract.id)
        file = given.name if given else self.failures.name(case.abstract.id)
        options = self.options
        return {"seed": options.seed, "suite": options.suites, "rerun_options": options.again, "file": file}

    def _result(self, case: HriCase, nodeid: str) -> TestResult:
        """The test's result, without what pytest says of it; built once for a run."""
        run = case.result
        if self._built is None or self._built[0] is not case or self._built[1] is not run:
            result = build_result(
                case,
                nodeid,
                run,
                code=self.code,
                requirements=self.requirements,
                unmeasured=why_unmeasured(run, self._used),
            )
            if run is not None and run.beside is not None:
                result = replace(result, beside=compare(run, run.beside, self.collection.testbench))
            given = self.collection.replays.get(case.abstract.id)
            if given is not None:
                result = replace(result, replay=given.name, replayed=self.provenance.compared(given, result))
            self._built = (case, run, result)
        return self._built[2]


def why_unmeasured(run: CaseResult | None, measurement: Measurement) -> str:
    """Why the code under test was not measured in a run, or not completely; empty where it was."""
    if run is None or (run.code is not None and run.code.branches is not None):
        return ""
    if measurement.reason or run.has_measured_node:
        return measurement.reason
    return (
        "the testbench's run wraps no node with run.measured: spawn the node of the code under test as "
        'run.kernel.spawn("robot", run.measured(robot))'
    )


def tolerated(failed: Iterable[str], known: Mapping[str, str]) -> str:
    """What is said of a test that only violated what is known to be violated."""
    return "known violation of " + "; ".join(f"{each} ({known[each]})" for each in failed)


def _outcome(report: pytest.TestReport, case: HriCase) -> TestOutcome:
    if report.outcome == "passed":
        return "passed" if case.result is not None else "error"
    if case.result is None:
        return "error"
    if not hasattr(report, "wasxfail"):
        return "failed"
    return "engine-sensitive" if report.wasxfail.startswith(ENGINE_SENSITIVE) else "known-violation"


def _text(report: pytest.TestReport) -> str:
    if report.outcome == "passed":
        return ""
    return str(getattr(report, "wasxfail", "") or report.longreprtext)
