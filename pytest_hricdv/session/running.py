"""Running: what happens around each generated test. Registered where tests run: in workers, or without xdist."""

from __future__ import annotations

import json
import os
from collections.abc import Generator, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TypedDict

import pytest

from pytest_hricdv.case import CaseResult, HriCase, execute
from pytest_hricdv.closure.closing import Entry
from pytest_hricdv.closure.results import describe, measured
from pytest_hricdv.cover.debugger import debugger
from pytest_hricdv.cover.measure import Measurement, NoMeasurement, choose
from pytest_hricdv.cover.source import CodeMap, CoverError, map_code
from pytest_hricdv.monitor import Requirement, RequirementError, load_requirements
from pytest_hricdv.report import explanation, junit
from pytest_hricdv.runtime import KernelError
from pytest_hricdv.session.collecting import Collecting, case_of
from pytest_hricdv.session.filming import Filming, told
from pytest_hricdv.session.replaying import Failures, Surroundings, strayed
from pytest_hricdv.session.typed_results import typed_result, typed_texts

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too

ATTRIBUTE = "hricdv"


class Again(TypedDict):
    """How a test can be run again."""

    seed: int
    suite: str
    more: tuple[str, ...]
    file: str


class Running:
    """Runs cases, measures them, and sends one JSON text per test along with pytest's own report."""

    def __init__(self, collecting: Collecting) -> None:
        self.collecting = collecting
        self.options = collecting.options
        self._used: Measurement = NoMeasurement("nothing has run")

    @cached_property
    def requirements(self) -> tuple[Requirement, ...]:
        """The testbench's requirements. Raises pytest.UsageError, located, when a text does not parse."""
        testbench = self.collecting.testbench
        try:
            return load_requirements(testbench.requirements, testbench.vocabulary())
        except (RequirementError, ValueError) as error:
            raise pytest.UsageError(str(error)) from None

    @property
    def known(self) -> Mapping[str, str]:
        """Requirements whose violation is known, with the reasons; none in a strict run."""
        return {} if self.options.strict else self.options.known

    @property
    def texts(self) -> dict[str, dict[str, str]]:
        """Requirement -> what people read of it."""
        return {each.id: {"title": each.title, "source": each.source, "text": each.text} for each in self.requirements}

    @cached_property
    def code(self) -> CodeMap:
        """What can be covered. Raises pytest.UsageError for code that is not there or a waiver without reason."""
        try:
            return map_code(self.collecting.testbench.code, Path(self.collecting.config.rootpath))
        except CoverError as error:
            raise pytest.UsageError(str(error)) from None

    @property
    def measurement(self) -> Measurement:
        """How the code under test is measured now: not at all while somebody debugs, and he may begin at any time."""
        if not self.options.coverage:
            return NoMeasurement("switched off with --hri-no-cov")
        stepping = self._stepping() or debugger()
        return NoMeasurement(stepping) if stepping else self._chosen

    def _stepping(self) -> str:
        given = self.collecting.config.option
        asked = [name for name, use in (("--pdb", "usepdb"), ("--trace", "trace")) if getattr(given, use, False)]
        return f"{asked[0]} was given: measuring would get in its way" if asked else ""

    @cached_property
    def _chosen(self) -> Measurement:
        by_test = getattr(self.collecting.config.option, "cov_context", None) == "test"
        return choose(self.code, contexts_by_test=by_test)

    @cached_property
    def surroundings(self) -> Surroundings:
        """What runs depend on, as it is in this process."""
        return Surroundings.now(self.code, self.collecting.testbench)

    @cached_property
    def failures(self) -> Failures:
        """Where the files of tests that failed are."""
        return Failures(self.options.report, self.collecting.config.invocation_params.dir)

    @cached_property
    def filming(self) -> Filming | None:
        """What films in this process, when asked to."""
        if not self.options.film:
            return None
        return Filming(self.collecting.testbench, self.requirements, self.options.report)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        """Lets go of the run when its test is over: pytest keeps all items to the end, and a run is large."""
        try:
            return (yield)
        finally:
            case = case_of(item)
            if case is not None:
                case.forget()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        """Lends the case its runner for the duration of the test, and tells JUnit how it went."""
        case = case_of(item)
        if case is None:
            return (yield)
        case.result, case.checked = None, False
        case.runner = lambda this: self._run(this, item.nodeid)
        case.judge = lambda this, result: self._judge(this, result, item.nodeid)
        try:
            yield
            self._see_that_it_was_checked(case)
        finally:
            case.runner = case.judge = None
            entry, label = self._entry(case, item.nodeid), self.collecting.testbench.outcome_label
            item.user_properties.extend(junit.properties(typed_result(entry), label))

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item: pytest.Item, call: pytest.CallInfo[None]) -> Iterator[None]:
        """Attaches the entry to the report of the call: a string, the one kind of data that crosses xdist safely."""
        report: pytest.TestReport = yield  # type: ignore[assignment]
        case = case_of(item)
        skipped = report.skipped and not hasattr(report, "wasxfail")  # then it has no result: it was not run
        if case is not None and call.when == "call" and not skipped:
            entry = self._entry(case, item.nodeid)
            entry |= {"outcome": _outcome(report, case), "wall_s": call.duration, "failure": _text(report)}
            self._film(case, entry, report)
            setattr(report, ATTRIBUTE, json.dumps(entry))
        return report  # type: ignore[return-value]

    def _film(self, case: HriCase, entry: Entry, report: pytest.TestReport) -> None:
        """Film what failed: here the test's time is taken already, and what it patched is still as it was."""
        if self.filming is None or case.result is None or entry["outcome"] not in ("failed", "known-violation"):
            return
        entry["film"] = self.filming.film(case.result)
        folder = os.path.relpath(self.options.report, self.collecting.config.invocation_params.dir)
        report.sections.append(("film", told(entry["film"], Path(folder))))

    def _run(self, case: HriCase, nodeid: str) -> CaseResult:
        testbench, self._used = self.collecting.testbench, self.measurement
        try:
            return execute(testbench, self.requirements, case.concrete, self._used, f"hricdv|{nodeid}")
        except Exception as error:
            # The author's own exception, from his own line, says more than that a node failed.
            failure = error.__cause__ if isinstance(error, KernelError) and error.__cause__ else error
            what = str(error) if isinstance(error, KernelError) else "the testbench's run failed"
        started = typed_result(describe(case, self.shown(nodeid)) | measured(None, None, ()))
        failure.add_note("\n" + explanation.aborted(started, what, **self._again(case)))
        raise failure

    def _see_that_it_was_checked(self, case: HriCase) -> None:
        if case.result is None:
            pytest.fail("the test ended without a run: call hri_case.check(hri_case.run())", pytrace=False)
        if not case.checked:
            case.check(case.result)

    def _judge(self, case: HriCase, result: CaseResult, nodeid: str) -> None:
        failed, known = result.failed, self.known
        replayed = strayed(self._entry(case, nodeid).get("replayed"))
        amiss = "\n".join(filter(None, [replayed, *result.illegal(self.collecting.testbench)]))
        if not failed and not amiss:
            return
        if not amiss and all(requirement in known for requirement in failed):
            pytest.xfail("known violation of " + "; ".join(f"{each} ({known[each]})" for each in failed))
        entry = self._entry(case, nodeid) | {"nodeid": self.shown(nodeid), "failure": amiss}
        units = self.collecting.testbench.units
        texts = typed_texts(self.texts)
        text = explanation.failure(typed_result(entry), texts, known=known, units=units, **self._again(case))
        pytest.fail(text, pytrace=False)

    def shown(self, nodeid: str) -> str:
        """The node id as it can be given to pytest in the folder where the run was started."""
        config = self.collecting.config
        path, colons, rest = nodeid.partition("::")
        return os.path.relpath(config.rootpath / path, config.invocation_params.dir) + colons + rest

    def _again(self, case: HriCase) -> Again:
        given = self.collecting.replays.get(case.abstract.id)
        file = given.name if given else self.failures.name(case.abstract.id)
        options = self.options
        return {"seed": options.seed, "suite": options.suites, "more": options.again, "file": file}

    def _entry(self, case: HriCase, nodeid: str) -> Entry:
        result = case.result
        entry = describe(case, nodeid) | measured(result, self.code, self.requirements)
        unmeasured = result is not None and (result.code is None or result.code.branches is None)
        entry["unmeasured"] = self._used.reason if unmeasured else ""
        given = self.collecting.replays.get(case.abstract.id)
        if given is not None:
            entry["replay"] = given.name
            entry["replayed"] = self.surroundings.compared(given, entry)
        return entry


def _outcome(report: pytest.TestReport, case: HriCase) -> str:
    if report.outcome == "passed":
        return "passed" if case.result is not None else "error"
    if case.result is None:
        return "error"
    return "known-violation" if hasattr(report, "wasxfail") else "failed"


def _text(report: pytest.TestReport) -> str:
    if report.outcome == "passed":
        return ""
    return str(getattr(report, "wasxfail", "") or report.longreprtext)
