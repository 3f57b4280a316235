"""`SessionReporter`: writes the report after the last test; `plugin` registers it in the controlling process."""

from __future__ import annotations

import contextlib
import datetime
import gc
import time
from collections import Counter
from collections.abc import Callable, Iterator
from functools import cached_property
from importlib.metadata import version
from typing import Any

import msgspec
import pytest

from pytest_hricdv._base.hash_seed import SEVERAL
from pytest_hricdv._base.self_check import complaint, wrong_answers
from pytest_hricdv.coverage.code_map import CoverageError
from pytest_hricdv.coverage.reachability import Reachability, explore, skip_exploration
from pytest_hricdv.execution.outcome import FAILING
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.context import GenerationContext
from pytest_hricdv.generate.model import beliefs_without_test, list_model
from pytest_hricdv.report import files
from pytest_hricdv.results.codec import ReportError, encode
from pytest_hricdv.results.gate_check import policy_of
from pytest_hricdv.results.model import ModelSource, Report, RerunOptions, TestResult
from pytest_hricdv.results.origin import ReportOrigin, origin_of_session
from pytest_hricdv.results.report_builder import SessionInfo, assemble, declare_report
from pytest_hricdv.session.aggregation import Aggregation
from pytest_hricdv.session.collection import Collection, explain_missing_items
from pytest_hricdv.session.feature import Feature, FeatureSession, features, not_done
from pytest_hricdv.session.preparation import GateCheck
from pytest_hricdv.session.pytest_options import runs_tests, say_without_terminal
from pytest_hricdv.session.run_context import RunContext


class SessionReporter:
    """Lets features follow up the tests, builds the report, checks the gates, writes the report."""

    def __init__(self, collection: Collection, context: RunContext, aggregation: Aggregation, gates: GateCheck) -> None:
        self.collection = collection
        self.context = context
        self.aggregation = aggregation
        self.options = collection.options
        self.report: Report | None = None
        self._gate_check = gates
        self._missing = ""
        self.session = FeatureSession(context, aggregation, context.signals)
        self._began = time.perf_counter()
        self._began_at = datetime.datetime.now(datetime.UTC)

    @pytest.hookimpl(trylast=True)
    def pytest_runtest_logstart(self) -> None:
        """With xdist, computes what does not depend on results, while the workers run their first tests.

        Not earlier: while workers start, it would take processor time from them and delay the first test.
        """
        if self.aggregation.is_distributed:
            self._declare()

    def _declare(self) -> None:
        self.aggregation.journaling.declare(self._declaration, self.aggregation.chosen.keys())

    @pytest.hookimpl(wrapper=True)
    def pytest_sessionstart(self, session: pytest.Session) -> Iterator[None]:
        """Like `pytest_collection`: workers of xdist are started here, which may take long."""
        with self._report_on_interrupt(session):
            return (yield)

    @pytest.hookimpl(wrapper=True)
    def pytest_collection(self, session: pytest.Session) -> Iterator[None]:
        """Writes the report of what was reached before the first test, where collecting is interrupted."""
        with self._report_on_interrupt(session):
            return (yield)

    @contextlib.contextmanager
    def _report_on_interrupt(self, session: pytest.Session) -> Iterator[None]:
        try:
            yield
        except KeyboardInterrupt:
            self.session.signals.let_go()
            self.session.interrupted = True
            if self.report is None and (self.aggregation.chosen or self._has_reached):
                self._conclude(session, stopped=True)
            raise

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> Iterator[None]:
        """Writes the report after the last test and `[100%]`, or what ends the session before; gates may fail it."""
        signals = self.session.signals
        signals.begin()
        try:
            with signals.defer():
                try:
                    with signals.release():
                        self._begin_tests(session.config)
                        result = yield
                except pytest.UsageError:  # before the first test
                    raise
                except BaseException as error:
                    self.session.interrupted = not isinstance(error, session.Failed)
                    self._conclude(session, stopped=True)
                    raise
                self.session.interrupted |= signals.interrupted
                self._conclude(session, stopped=False)
        finally:
            signals.end()
        if self.session.interrupted or signals.pending:
            raise KeyboardInterrupt
        return result

    def _begin_tests(self, config: pytest.Config) -> None:
        if self.aggregation.chosen and not self.aggregation.is_distributed and runs_tests(config):
            self._declare()  # not within a test: plugins that limit its time count what happens in its hooks

    def _conclude(self, session: pytest.Session, *, stopped: bool) -> None:
        reached = self._has_reached and (stopped or not self.collection.cases)
        if reached and not self.aggregation.chosen:
            self._collect_here(session)
        nothing_to_report = not (self.aggregation.chosen or self._is_empty_shard or reached)
        if not runs_tests(session.config) or nothing_to_report:
            # xdist does not report node ids that its workers did not find.
            self._missing = "" if self.aggregation.chosen else explain_missing_items(session.config.args, self.options)
            if not stopped:
                self.aggregation.journaling.withdraw()
            return
        gc.collect()  # what finalizers of the code say at any moment breaks a parse of Python 3.11 that goes on then
        with self.session.signals.defer():
            self._report(stopped=stopped)
        session.testsfailed += bool(self.session.problems)

    @property
    def _has_reached(self) -> bool:
        """Something is to be reported, even if there is no test: what a loop has done that generated a suite."""
        made = self.collection.__dict__.get("suites", ())  # not to be generated now
        return any(generated.sections and not generated.cached for generated in made)

    def _collect_here(self, session: pytest.Session) -> None:
        """Finds which tests were selected, where no worker of xdist has said so, and none will."""
        with self.session.signals.defer(), contextlib.suppress(Exception):  # then the report is without tests
            if not getattr(session, "items", ()):
                session.perform_collect()

    def _report(self, *, stopped: bool) -> None:
        """Makes the report and writes it."""
        journaling, session = self.aggregation.journaling, self.session
        is_judged = not (stopped or session.interrupted)  # a loop that was interrupted has generated another suite
        self._declare()
        session.results = self.aggregation.results()
        for feature in features():
            session.results = feature.after_tests(session, session.results, stopped=stopped)
        session.problems += self.aggregation.each_worker.differences()
        session.warnings += [*self.aggregation.notes(), *self._warn_of_untested_beliefs()]
        replaced = wrong_answers()
        session.problems += [complaint(replaced)] if replaced else []
        if self.context.failures.problem:
            session.problems.append(self.context.failures.problem)
        report = msgspec.structs.replace(self._build(session.results), **session.sections)
        report = report if stopped else self._extend(report, Feature.extend_report)
        report = self._gate_check.compare(report, whole=self._is_whole and self.options.shard is None)
        report = self._judge(report) if is_judged else report
        session.is_whole = self._is_whole and not (stopped or session.interrupted)
        report = self._extend(report, Feature.after_gates)
        if not (is_judged or report.not_run):  # otherwise the tests without a result say that the report is a part
            report = msgspec.structs.replace(report, problems=not_done(self.context, session.done))
        self.report = self._write(report)
        journaling.end(is_whole=session.is_whole)

    def _extend(self, report: Report, step: Callable[[Feature[Any], FeatureSession, Report], Report]) -> Report:
        """The report with what each feature adds to it at a step, a method of `Feature`."""
        for feature in features():
            report = getattr(feature, step.__name__)(self.session, report)
        return report

    def _write(self, report: Report) -> Report:
        """The report, written; what cannot be written is a problem of the session."""
        session = self.session
        try:
            kept = self.aggregation.journaling.keep_whole(is_whole=session.is_whole)
            report = msgspec.structs.replace(report, full_report=kept)
        except ReportError as error:
            session.problems.append(str(error))
        try:
            files.write(report, self.options.report)
        except ReportError as error:
            session.problems.append(str(error))
        return report

    def _build(self, results: list[TestResult]) -> Report:
        """The report; without the code's coverage, and with a problem, when a waiver in the code is wrong."""
        declared = msgspec.json.decode(self._declaration, type=Report)
        origin = self._with_hash_seed(declared.origin)
        declared = msgspec.structs.replace(declared, workers=self.aggregation.workers, origin=origin, problems=())
        resumed = self.aggregation.journaling.resumed
        wall_s = time.perf_counter() - self._began + (resumed.wall_s if resumed else 0.0)
        report, problem = assemble(declared, results, self.aggregation.reasons, wall_s)
        if problem:
            self.session.problems.append(problem)
        return report

    def _with_hash_seed(self, origin: ReportOrigin | None) -> ReportOrigin | None:
        """Where the report comes from, with the hash seed that tests had, also those of an earlier session."""
        seed = self.aggregation.hash_seed
        if origin is None:
            return None
        if seed == SEVERAL:
            seeds = ", ".join(sorted(self.aggregation.worker_hash_seeds))
            self.session.warnings.append(
                f"workers have different hash seeds ({seeds}), so they go through sets in different orders: set "
                "PYTHONHASHSEED where they are started"
            )
        resumed = self.aggregation.journaling.resumed
        if resumed is not None and resumed.declared is not None and origin.hash_seed not in ("", seed):
            seed = SEVERAL
        return msgspec.structs.replace(origin, hash_seed=seed)

    @cached_property
    def _declaration(self) -> bytes:
        """The report before the first result, as JSON: not as objects, which of thousands of tests would be many."""
        resumed = self.aggregation.journaling.resumed
        if resumed is not None and resumed.declared is not None:
            _ = self._reachability  # for its problems, which fail this session, too
            return resumed.declared
        declared = declare_report(self.session_info(), self.aggregation.chosen)
        config, environment = self.collection.config, self.context.provenance.environment
        arguments = config.invocation_params.args
        origin = origin_of_session(arguments, config.rootpath, config.inipath, self._began_at, environment)
        origin = msgspec.structs.replace(origin, hash_seed=self.aggregation.hash_seed)
        # The content of a report that is rebuilt if this session is killed.
        return encode(msgspec.structs.replace(declared, origin=origin, problems=not_done(self.context))).encode()

    @property
    def reason_for_missing_tests(self) -> str:
        """Why tests that the command line names were not found; empty if all were."""
        return self._missing

    def session_info(self) -> SessionInfo:
        """The content of the report besides results."""
        return SessionInfo(
            testbench=self.collection.testbench,
            requirements=self.context.requirements,
            suites=tuple(self.collection.suites),
            code=self.context.code,
            unmeasured="no test was measured" if self.options.coverage else "switched off",
            known_violations=self.options.known_violations,
            allowed_untriggered=self.options.gates.allowed_untriggered,
            until={
                name: str(exemption.until)
                for name, exemption in self.options.gates.known_violations.items()
                if exemption.until
            },
            strict=self.options.strict,
            version=version("pytest-hricdv"),
            environment=self.context.provenance.environment,
            workers=self.aggregation.workers,
            sizes=Counter(case.suite for case in self.collection.all_cases),
            shard=str(self.options.shard or ""),
            policy=policy_of(self.options.gates),
            rerun=RerunOptions(suite=self.options.suites, options=self.options.again),
            models=self._models,
            reachability=self._reachability,
        )

    @cached_property
    def _reachability(self) -> Reachability:
        """The points that the model makes impossible; also for replayed tests, so that their figures use the same
        bins."""
        testbench = self.collection.testbench
        commands = tuple(testbench.concretization.commands)
        context = GenerationContext(model=testbench.model, space=testbench.beliefs, commands=commands)
        try:
            return explore(context, testbench.cross, getattr(self.collection.config, "cache", None))
        except CoverageError as error:
            self.session.problems.append(str(error))
            return skip_exploration(testbench.cross)

    @cached_property
    def _models(self) -> dict[str, ModelSource]:
        """The models' text. A suite that came from files needs none, so a broken model is not reported here."""
        try:
            listed = list_model(self.collection.testbench.model, self.collection.config.rootpath)
        except GenerateError:
            return {}
        return msgspec.convert(listed, dict[str, ModelSource])

    def _warn_of_untested_beliefs(self) -> list[str]:
        """Names in the belief space without effect; a broken model is reported elsewhere."""
        space = self.collection.testbench.beliefs
        named = [belief for belief in space.beliefs if belief not in space.default_beliefs]
        try:
            untested = beliefs_without_test(self.collection.testbench.model, named)
        except GenerateError:
            return []
        if not untested:
            return []
        return [
            f"no agent tests {', '.join(untested)} of the belief space, in no trigger, context or condition, so "
            "choosing it changes no test: correct the name, let a plan test it, or make it a default belief"
        ]

    @property
    def _is_whole(self) -> bool:
        """All tests of the suites were selected, or of the shard."""
        ids = {case.abstract.id for case in self.aggregation.chosen.values()}
        return not self.collection.replays and ids == {case.abstract.id for case in self.collection.cases}

    @property
    def _is_empty_shard(self) -> bool:
        """This shard has no test; its report is still needed for the merge."""
        return self.options.shard is not None and bool(self.collection.all_cases) and not self.collection.cases

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Corrects the exit status of a shard without tests, which is not an error, and of a session that lost tests.

        `pytest.exit(returncode=0)` in the code under test would else look as if all were well.
        """
        if self._is_empty_shard and session.exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED:
            session.exitstatus = pytest.ExitCode.OK
        if self.report is not None and session.exitstatus == pytest.ExitCode.OK:
            self.session.problems += [*self.aggregation.losses(), *_unsaid_failures(self.report)]
            if self.session.problems:
                session.exitstatus = pytest.ExitCode.TESTS_FAILED
        say_without_terminal(session.config, self.session.problems)

    def _judge(self, report: Report) -> Report:
        """The report of a session that ran to its end, with the result of its gates.

        A shard has no gates: they apply to the merged report.
        """
        report = msgspec.structs.replace(report, problems=(*self.session.problems, *self.aggregation.late_errors()))
        self.session.problems += self.aggregation.losses()
        if self.options.shard is not None:
            return report
        checked = self._gate_check.judge(report, whole=self._is_whole)
        self.session.problems += checked.failed
        gates = msgspec.structs.replace(checked, failed=tuple(self.session.problems))
        return msgspec.structs.replace(report, gates=gates)


def _unsaid_failures(report: Report) -> list[str]:
    """Failures that pytest does not report, for instance because another plugin's hook changes the outcome."""
    failing = [test.nodeid for test in report.tests if test.outcome in FAILING]
    if not failing:
        return []
    return [
        f"{len(failing)} of {len(report.tests)} tests failed or are in error, first {failing[0]}, which pytest hides"
    ]
