"""Reporting: where the results of all workers meet. Registered in the controlling process only."""

from __future__ import annotations

import importlib
import re
import shutil
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from importlib.metadata import version

import msgspec
import pytest

from pytest_hricdv.case import HriCase
from pytest_hricdv.coverage.code_map import CoverageError
from pytest_hricdv.coverage.reachability import Reachability, explore, unexplored
from pytest_hricdv.generate.context import GenerationContext
from pytest_hricdv.generate.error import GenerateError
from pytest_hricdv.generate.model import list_model
from pytest_hricdv.report import files, findings, terminal
from pytest_hricdv.results.building import SessionInfo, build_report
from pytest_hricdv.results.codec import ReportError, decode
from pytest_hricdv.results.model import GateResult, ModelSource, Report, RerunOptions, SearchResult, TestResult
from pytest_hricdv.session import films
from pytest_hricdv.session.collection import Collection, case_of, missing_items
from pytest_hricdv.session.gate_check import GateCheck
from pytest_hricdv.session.post_session import PostSession
from pytest_hricdv.session.replaying import LEAVE_A_FILE
from pytest_hricdv.session.rerunning import Rerunning
from pytest_hricdv.session.result_store import ResultStore
from pytest_hricdv.session.running import ATTRIBUTE, Running
from pytest_hricdv.session.suites import export
from pytest_hricdv.testbench import TestbenchError

MARKUP: dict[str, dict[str, bool]] = {
    "title": {"bold": True},
    "ok": {"green": True},
    "bad": {"red": True, "bold": True},
    "warn": {"yellow": True},
    "dim": {"light": True},
    "plain": {},
}
_DIGEST = re.compile(r"-[0-9a-f]{8,16}(?:-corners)?(?:-k\d+)?(?=[-\]])")


class _Head(msgspec.Struct):
    """All that decides whether a result has to be decoded when it arrives."""

    outcome: str


class Reporting:
    """Collects results by node id, checks that none is lost and that the gates are passed, writes the report."""

    def __init__(self, collecting: Collection, running: Running) -> None:
        self.collecting = collecting
        self.running = running
        self.options = collecting.options
        self.results = ResultStore()
        self._replays: dict[str, str] = {}
        self.reasons: dict[str, str] = {}
        self.chosen: dict[str, HriCase] = {}
        self.workers = 1
        self.report: Report | None = None
        self.problems: list[str] = []
        self.interrupted = False
        self.absent = ""
        self._distributed = False
        self._began = time.perf_counter()

    def pytest_report_header(self) -> str | list[str]:
        """One line; generates the suites, so that it can say how many tests there are. More where a replay is amiss."""
        if self.collecting.replays:
            return self._replay_header()
        suites = self.collecting.selected
        names = [each.suite.name for each in suites]
        tests = len(self.collecting.cases)
        return terminal.header(names, self.options.seed, tests, self.collecting.testbench.name)

    def _replay_header(self) -> list[str]:
        given = self.collecting.replays.values()
        notes = [self.running.provenance.note(each) for each in given]
        return [findings.replay_header(self.collecting.testbench.name, len(given)), *(note for note in notes if note)]

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionstart(self) -> None:
        """Finds what is wrong with the testbench, its files and the report folder before any test runs; exports."""
        self._gate_check.check({requirement.id for requirement in self.running.requirements})
        _ = self.running.code
        self._check_replays()
        if self.options.film:
            self._check_film()
        running = not self.collecting.config.getoption("collectonly")
        if running:
            self._import_required()
        _ = self.collecting.selected  # learning takes its time, so it comes after what is quickly checked
        if self.options.export is not None:
            export(self.collecting.selected, self.options.export)
        if running:
            try:
                files.prepare(self.options.report)
            except ReportError as error:
                raise pytest.UsageError(str(error)) from None

    def _check_replays(self) -> None:
        """Refuse files whose runs cannot be expected to be the same, unless they are to be run anyway."""
        notes = [self.running.provenance.note(each) for each in self.collecting.replays.values()]
        changed = [note for note in notes if note]
        if changed and not self.options.replay_anyway:
            told = "\n  ".join(changed)
            raise pytest.UsageError(f"--hri-replay: {told}\nadd --hri-replay-anyway to run it all the same")

    def _check_film(self) -> None:
        try:
            films.check(self.collecting.testbench)
        except TestbenchError as error:
            raise pytest.UsageError(str(error)) from None

    def _import_required(self) -> None:
        for name in self.collecting.testbench.requires:
            try:
                importlib.import_module(name)
            except ImportError as error:
                raise pytest.UsageError(f"the testbench requires {name}: {error}") from None

    def pytest_collection_finish(self, session: pytest.Session) -> None:
        """Without xdist: notes which tests were chosen."""
        for item in session.items:
            case = case_of(item)
            if case is not None:
                self.chosen[item.nodeid] = case

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_setupnodes(self, specs: list[object]) -> None:
        """With xdist: notes how many workers there are at a time; the ones that replace a crashed one do not add."""
        self.workers = len(specs)
        self._distributed = True

    @pytest.hookimpl(optionalhook=True)
    def pytest_xdist_node_collection_finished(self, node: object, ids: list[str]) -> None:
        """With xdist: the controller never collects, so the workers' node ids say what was chosen."""
        by_id = {case.abstract.id: case for case in self.collecting.cases}
        for nodeid in ids:
            case = _case_named(nodeid, by_id)
            if case is not None:
                self.chosen[nodeid] = case

    @pytest.hookimpl(trylast=True)
    def pytest_runtest_logstart(self) -> None:
        """With xdist: computes what does not depend on results while the workers run their first tests.

        Not earlier: while workers start, it would take processor time from them and delay the first test.
        """
        if self._distributed:
            _ = self._reachability, self._models

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Takes the result from a report, of whichever worker; the same test twice counts once.

        A report without a result says why there is none: skipped, a fixture that failed, a worker that crashed.
        """
        text = getattr(report, ATTRIBUTE, None)
        if isinstance(text, str):
            self.results.put(report.nodeid, text)
            self._keep_failure(text)
            delattr(report, ATTRIBUTE)  # pytest keeps reports to the end
        elif not report.passed:
            self.reasons[report.nodeid] = (
                report.longrepr[2] if isinstance(report.longrepr, tuple) else report.longreprtext
            )

    def _keep_failure(self, text: str) -> None:
        """Writes the replay file of a failed test; that of a replayed test exists already."""
        if msgspec.json.decode(text, type=_Head).outcome not in LEAVE_A_FILE:
            return
        result = decode(text)
        case = self.chosen.get(result.nodeid)
        if result.replay is None and case is not None:
            replay = self.running.provenance.replay(case, result, self._rerunning.seeds[case.suite])
            name = self.running.failures.keep(replay)
            if name is not None:
                self._replays[result.nodeid] = name

    def _all_results(self) -> list[TestResult]:
        """With the names of the replay files that were written here."""
        return [
            msgspec.structs.replace(result, replay=self._replays[result.nodeid])
            if result.replay is None and result.nodeid in self._replays
            else result
            for result in self.results.results()
        ]

    @pytest.hookimpl(wrapper=True)
    def pytest_runtestloop(self, session: pytest.Session) -> Iterator[None]:
        """After the last test, or the last before -x or Ctrl-C: writes the report, and lets gates fail the session."""
        try:
            result = yield
        except session.Failed:
            self._conclude(session, stopped=True)
            raise
        except (session.Interrupted, KeyboardInterrupt):
            self.interrupted = True
            self._conclude(session, stopped=True)
            raise
        self._conclude(session, stopped=False)
        if self.interrupted:
            raise KeyboardInterrupt
        return result

    def _conclude(self, session: pytest.Session, *, stopped: bool) -> None:
        nothing_to_report = not self.chosen and not self._is_empty_shard
        if session.config.getoption("collectonly") or nothing_to_report:
            # xdist says nothing of node ids that its workers did not find.
            self.absent = "" if self.chosen else missing_items(session.config.args, self.options)
            return
        results, searched = self._post_session(self._all_results(), stopped=stopped)
        if self.running.failures.problem:
            self.problems.append(self.running.failures.problem)
        self.report = msgspec.structs.replace(self._build(results), search=searched)
        if not stopped:
            self.report = self._judged(self.report)
        try:
            files.write(self.report, self.options.report)
        except ReportError as error:
            self.problems.append(str(error))
        if self.problems:
            session.testsfailed += 1

    def _post_session(
        self, results: list[TestResult], *, stopped: bool
    ) -> tuple[list[TestResult], dict[str, SearchResult]]:
        """Shrinks and searches, where asked to; returns the results with what they were shrunk to, and the search."""
        options = self.options
        if self.interrupted or not (options.shrink or options.search):
            return results, {}
        self.collecting.say("")  # ends the line of dots
        after = PostSession(self._rerunning, options, self.chosen, self.collecting.say)
        if options.shrink:
            results = after.shrink(results)
        found = after.search(results) if options.search and not stopped else {}
        self.interrupted = after.interrupted
        self.problems += after.problems
        return results, found

    @property
    def _rerunning(self) -> Rerunning:
        running, selected = self.running, self.collecting.selected
        seeds = {each.suite.name: each.suite.seed for each in selected}
        return Rerunning(self.collecting.testbench, running.requirements, running.provenance, running.failures, seeds)

    def _build(self, results: list[TestResult]) -> Report:
        """The report; without the code's coverage, and with a problem, when a waiver in the code is wrong."""
        session = self._session(results)
        try:
            return build_report(session, results, self.chosen, self.reasons)
        except CoverageError as error:
            self.problems.append(str(error))
            return build_report(replace(session, code=None, unmeasured=str(error)), results, self.chosen, self.reasons)

    def _loss(self) -> list[str]:
        """Tests without a result or a reason: the session must not look as if all were well."""
        lost = len(self.chosen.keys() - self.results.nodeids() - self.reasons.keys())
        return [f"{lost} of {len(self.chosen)} tests left no result: a worker or a plugin lost them"] if lost else []

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """One section at the end."""
        if self.absent:
            terminalreporter.write_line(f"hricdv: {self.absent.strip()}", red=True)
        if self.report is None and not self.problems:
            return
        terminalreporter.write_sep("=", "human-robot interaction")
        if self.report is not None:
            for line in terminal.summary(self.report, self.options.report, shutil.get_terminal_size().columns):
                terminalreporter.write_line(line.text, **MARKUP[line.style])
            for line in findings.findings(self.report):
                terminalreporter.write_line(line.text, **MARKUP[line.style])
        for text in self.report.gates.improved if self.report and self.report.gates else ():
            terminalreporter.write_line(text, green=True)
        for problem in self.problems:
            terminalreporter.write_line(f"FAILED {problem}", red=True, bold=True)

    def _session(self, results: list[TestResult]) -> SessionInfo:
        measured = self.options.coverage
        reasons = [result.unmeasured for result in results if result.unmeasured]
        return SessionInfo(
            testbench=self.collecting.testbench,
            requirements=self.running.requirements,
            suites=tuple(self.collecting.selected),
            code=self.running.code,
            unmeasured=reasons[0] if reasons else "no test was measured" if measured else "switched off",
            known=self.options.known,
            until={name: str(each.until) for name, each in self.options.gates.known.items() if each.until},
            strict=self.options.strict,
            version=version("pytest-hricdv"),
            wall_s=time.perf_counter() - self._began,
            workers=self.workers,
            sizes=Counter(case.suite for case in self.collecting.everything),
            shard=str(self.options.shard or ""),
            rerun=RerunOptions(suite=self.options.suites, options=self.options.again),
            models=self._models,
            reachability=self._reachability,
        )

    @cached_property
    def _reachability(self) -> Reachability:
        """What the model makes impossible. For replayed tests the model is not explored."""
        testbench = self.collecting.testbench
        if not self.collecting.replays:
            commands = tuple(testbench.concretization.commands)
            context = GenerationContext(model=testbench.model, space=testbench.beliefs, commands=commands)
            try:
                return explore(context, testbench.cross, getattr(self.collecting.config, "cache", None))
            except CoverageError as error:
                self.problems.append(str(error))
        return unexplored(testbench.cross)

    @cached_property
    def _models(self) -> dict[str, ModelSource]:
        """The models' text. A suite that came from files needs none, so a broken model is not reported here."""
        try:
            listed = list_model(self.collecting.testbench.model, self.collecting.config.rootpath)
        except GenerateError:
            return {}
        return msgspec.convert(listed, dict[str, ModelSource])

    @cached_property
    def _gate_check(self) -> GateCheck:
        return GateCheck(self.options, self.collecting.testbench.name)

    @property
    def _is_empty_shard(self) -> bool:
        """This shard has no test; its report is still needed for the merge."""
        return self.options.shard is not None and bool(self.collecting.everything) and not self.collecting.cases

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """A shard without tests is no error, though pytest has a status for it that fails a job."""
        if self._is_empty_shard and session.exitstatus == pytest.ExitCode.NO_TESTS_COLLECTED:
            session.exitstatus = pytest.ExitCode.OK

    def _judged(self, report: Report) -> Report:
        """The report of a session that came to its end, with the result of its gates.

        A shard has no gates: they apply to the merged report.
        """
        if self.options.shard is not None:
            self.problems += self._loss()
            return report
        ids = {case.abstract.id for case in self.chosen.values()}
        whole = not self.collecting.replays and ids == {case.abstract.id for case in self.collecting.cases}
        judgement = self._gate_check.judge(report, whole=whole)
        self.problems += [*self._loss(), *judgement.failed]
        return msgspec.structs.replace(
            report, gates=GateResult(failed=tuple(self.problems), improved=judgement.improved)
        )


def _case_named(nodeid: str, by_id: dict[str, HriCase]) -> HriCase | None:
    """The case whose id stands in the brackets of a node id, among other parameters perhaps."""
    parameters = nodeid[nodeid.find("[") + 1 :]
    for match in _DIGEST.finditer(parameters):
        head = parameters[: match.end()]
        for start in [0, *(dash.end() for dash in re.finditer("-", head))]:
            if head[start:] in by_id:
                return by_id[head[start:]]
    return None
