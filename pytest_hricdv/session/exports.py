"""`Exporter`: writes files for other tools (`report.exports`) after the report, in the controlling process.

`plugin` registers it with the files that `read_targets` finds in the options. In every process it also registers the
`attachers`, which add timelines and films of tests to the reports of allure-pytest and pytest-html.
"""

from __future__ import annotations

import base64
import contextlib
import os
import xml.etree.ElementTree as ET
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from pytest_hricdv._base import own_json as json
from pytest_hricdv._base.contained import file_inside
from pytest_hricdv._base.message import visible
from pytest_hricdv.report import EXPORT_FORMATS, files, junit
from pytest_hricdv.report.annotations import Place, annotation_commands
from pytest_hricdv.report.exports import ExportTargets, write_exports
from pytest_hricdv.report.failing_tests import FailingTests
from pytest_hricdv.report.files import PAGE_NAME
from pytest_hricdv.report.tests_view import anchor
from pytest_hricdv.report.view import views
from pytest_hricdv.report.violations import violation_line
from pytest_hricdv.results.codec import ReportError, decode
from pytest_hricdv.results.model import Report, TestResult
from pytest_hricdv.session.collection import ATTRIBUTE
from pytest_hricdv.session.option import usage_error
from pytest_hricdv.session.pytest_options import runs_tests, say_without_terminal

if TYPE_CHECKING:
    from pytest_hricdv.session.collection import Collection
    from pytest_hricdv.session.reporting import SessionReporter

_ID = "hri.id"
"""The JUnit property that marks a test case of the JUnit file as a generated test."""


def read_targets(config: pytest.Config) -> ExportTargets:
    """The files that options and ini keys name. Raises pytest.UsageError for one that cannot be written."""
    named = {name: _path(config, name) for name in EXPORT_FORMATS}
    paths = [path for path in named.values() if path is not None]
    twice = next((path for path in paths if paths.count(path) > 1), None)
    if twice is not None:
        names = " and ".join(f"--hri-{name}" for name, path in named.items() if path == twice)
        raise usage_error(f"{names}: expected a file for each, and both are to be {twice}")
    return ExportTargets.of(named)


def _path(config: pytest.Config, name: str) -> Path | None:
    option = config.getoption(f"hri_{name}")
    text = str(config.getini(f"hri_{name}") if option is None else option).strip()
    if not text:
        if option is not None:
            raise usage_error(f"--hri-{name}: expected the name of a file to write")
        return None
    path = config.invocation_params.dir / text
    if path.is_dir():
        raise usage_error(f"--hri-{name}={text}: expected the name of a file to write, and there is a folder")
    return path


class Exporter:
    """Writes the files after the report, also of a stopped session; a file that cannot be written fails it."""

    def __init__(self, config: pytest.Config, reporting: SessionReporter, targets: ExportTargets) -> None:
        self._config = config
        self._reporting = reporting
        self._targets = targets
        self._places: dict[str, Place] = {}
        self._notes: list[str] = []
        self._problems: list[str] = []

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionstart(self) -> None:
        """Checks before the first test that the files can be written after the last."""
        targets = self._targets
        if not runs_tests(self._config):
            return
        for path in (targets.cobertura, targets.lcov, targets.summary):
            if path is not None:
                try:
                    files.prepare(path.parent)
                except ReportError as error:
                    raise usage_error(f"{path}: {error}") from None

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Stores the place of the test function."""
        file, line, _ = report.location
        self._places[report.nodeid] = (self._in_repository(file), (line or 0) + 1)

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> Iterator[None]:
        """The outermost wrapper: the report exists when the others have ended."""
        try:
            return (yield)
        finally:
            if self._reporting.report is not None:
                self._export(self._reporting.report)
                session.testsfailed += bool(self._problems)
                say_without_terminal(self._config, self._problems)

    @pytest.hookimpl(trylast=True)
    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Writes where the files are, errors, and GitHub's annotations."""
        for note in self._notes:
            terminalreporter.write_line(visible(note), light=True)
        for problem in self._problems:
            terminalreporter.write_line(visible(f"FAILED {problem}"), red=True, bold=True)
        if self._targets.github and self._reporting.report is not None:
            for annotation in annotation_commands(self._reporting.report, self._places, self._in_repository):
                terminalreporter.write_line(annotation)

    def _export(self, report: Report) -> None:
        self._tell_junit(report)
        written = write_exports(report, self._targets, str(self._config.rootpath))
        self._notes += written.notes
        self._problems += written.problems

    def _tell_junit(self, report: Report) -> None:
        # pytest's documented way, `record_testsuite_property`, is a fixture: with xdist, fixtures run in workers, where
        # no XML is written.
        for plugin in self._config.pluginmanager.get_plugins():
            if hasattr(plugin, "add_global_property"):
                for name, value in junit.junit_suite_properties(report):
                    plugin.add_global_property(name, value)
                tell_causes(report, getattr(plugin, "node_reporters_ordered", ()))

    def _in_repository(self, file: str) -> str:
        """A file's name as GitHub expects it: relative to the checked-out repository, with slashes."""
        root = os.environ.get("GITHUB_WORKSPACE") or self._config.invocation_params.dir
        return Path(os.path.relpath(self._config.rootpath / file, root)).as_posix()


def tell_causes(report: Report, reporters: Iterable[Any]) -> None:
    """Add causes to the elements of failing tests in the JUnit file: to the message, which CI services show.

    pytest makes a test's element when the test has ended, and writes all of them at the end of the session; what tests
    fail for is known in between.

    Args:
        reporters: of pytest's plugin `junitxml`: each has the element of a test that has ended.
    """
    failing = FailingTests.of(report)
    labels = failing.labels()
    by_id = {test.id: labels[nodeid] for nodeid, test in failing.tests.items() if nodeid in labels}
    for reporter in reporters if by_id else ():
        element = reporter.to_xml()
        properties = element.find("properties")
        of_test = {} if properties is None else {entry.get("name"): entry.get("value") for entry in properties}
        label = by_id.get(str(of_test.get(_ID, "")))
        if label is not None and properties is not None:
            ET.SubElement(properties, "property", name="hri.cause", value=visible(label))
            for failure in element.iter("failure"):
                _label(failure, visible(label))


def _label(failure: ET.Element, label: str) -> None:
    """Name the cause at the end of the first line, in the message and in the text."""
    first = failure.get("message", "")
    if first and "\n" not in first:
        failure.set("message", f"{first} ({label})")
        text = failure.text or ""
        failure.text = f"{first} ({label}){text.removeprefix(first)}" if text.startswith(first) else text


LINK = "pytest-hricdv"
TIMELINE = "timeline"


class Attacher(ABC):
    """Attaches to one kind of report.

    Args:
        collection: knows the folder of our report, and units.
    """

    def __init__(self, collection: Collection) -> None:
        self._collection = collection
        self._folder = collection.options.report

    @pytest.hookimpl(wrapper=True, tryfirst=True)  # outside of what attaches the result
    def pytest_runtest_makereport(self) -> Iterator[None]:
        """Attaches to the report of a call that has a result."""
        report: pytest.TestReport = yield  # type: ignore[assignment]
        text = getattr(report, ATTRIBUTE, None)
        if text is not None:
            self.attach(report, decode(text))
        return report  # type: ignore[return-value]

    @abstractmethod
    def attach(self, report: pytest.TestReport, result: TestResult) -> None:
        """Attach what there is of a test."""

    def _timeline(self, result: TestResult) -> str:
        return timeline_text(result, self._collection.testbench.units)

    def _link(self, result: TestResult, start: Path) -> str:
        """The page of a test, from a folder: reports are carried away together."""
        return f"{relative(self._folder / PAGE_NAME, start)}#test/{anchor(result.nodeid)}"

    def _pictures(self, result: TestResult) -> Iterator[tuple[str, Path]]:
        """Name and file of what parts show of it, as its film."""
        for view in views():
            for name, file in view.pictures(result):
                with contextlib.suppress(OSError):  # a link: what it leads to is no picture of this run
                    yield name, file_inside(self._folder, file)


class AllureAttacher(Attacher):
    """Attaches to Allure's results."""

    def __init__(self, collection: Collection, results: Path) -> None:
        super().__init__(collection)
        self._results = results

    def attach(self, report: pytest.TestReport, result: TestResult) -> None:
        """Attach what there is of a test."""
        import allure

        allure.dynamic.link(self._link(result, self._results), name=LINK)  # type: ignore[no-untyped-call]
        allure.attach(self._timeline(result), name=TIMELINE, attachment_type=allure.attachment_type.TEXT)
        for name, path in self._pictures(result):
            kind = allure.attachment_type[path.suffix[1:].upper()]
            allure.attach.file(str(path), name=name, attachment_type=kind)  # type: ignore[no-untyped-call]


class HtmlAttacher(Attacher):
    """Attaches to pytest-html's page; where that holds everything itself, it holds films, too."""

    def __init__(self, collection: Collection, page: Path, *, self_contained: bool) -> None:
        super().__init__(collection)
        self._page = page
        self._self_contained = self_contained

    def attach(self, report: pytest.TestReport, result: TestResult) -> None:
        """Attach what there is of a test."""
        from pytest_html import extras

        attached = [
            extras.url(self._link(result, self._page.parent), name=LINK),
            extras.text(self._timeline(result), name=TIMELINE),
        ]
        for name, path in self._pictures(result):
            kind = extras.mp4 if path.suffix == ".mp4" else extras.image
            content = relative(path, self._page.parent)
            if self._self_contained:
                content = base64.b64encode(path.read_bytes()).decode()
            attached.append(kind(content, name=name))
        setattr(report, "extras", [*getattr(report, "extras", []), *attached])  # noqa: B010


def attachers(collection: Collection) -> Iterator[Attacher]:
    """The attachers, one for each installed plugin that writes a report in this session."""
    config = collection.config
    results = config.getoption("allure_report_dir", None)
    if _is_loaded(config, "allure_pytest", "allure_pytest.plugin") and results:
        yield AllureAttacher(collection, Path(os.path.abspath(results)))
    page = config.getoption("htmlpath", None)
    if _is_loaded(config, "html", "pytest_html.plugin") and page:
        contained = bool(config.getoption("self_contained_html", False))
        yield HtmlAttacher(collection, Path(os.path.abspath(page)), self_contained=contained)


def _is_loaded(config: pytest.Config, *names: str) -> bool:
    """Whether there is a plugin, by the name of its entry point or, with `-p`, of its module."""
    return any(map(config.pluginmanager.hasplugin, names))


def relative(path: Path, start: Path) -> str:
    """The address of a file, from a page in a folder."""
    try:
        return Path(os.path.relpath(path, start)).as_posix()
    except ValueError:  # on another drive
        return path.absolute().as_uri()


def timeline_text(test: TestResult, units: Mapping[str, str]) -> str:
    """The timeline with one line per event: time (s), who, what. A line notes an incomplete run.

    Args:
        test: a test, with its timeline.
        units: signal -> unit, for the values at violations.
    """
    if test.timeline is None:
        return "no timeline: the run was not completed\n"
    events = [*_messages(test), *_actions(test), *_violations(test, units), *_list_undecided_events(test)]
    events.append((test.timeline.end_s, "", test.end_reason))
    lines = (
        f"{time_s:9.3f}  {sender:10}  {event}".rstrip()
        for time_s, sender, event in sorted(events, key=lambda event: event[0])
    )
    return "".join(f"{visible(line)}\n" for line in lines)


def _messages(test: TestResult) -> Iterator[tuple[float, str, str]]:
    for text in test.timeline.messages if test.timeline else ():
        time_s, sender, topic, fields = text.split("\t", 3)
        said = ", ".join(f"{name} {value}" for name, value in json.loads(fields).items())
        yield float(time_s), sender, f"{topic} {said}".rstrip()


def _actions(test: TestResult) -> Iterator[tuple[float, str, str]]:
    for time_s, number in test.action_starts:
        yield time_s, f"action {number + 1}", test.abstract[number]
    for time_s, act in test.bystander_events:
        yield time_s, "bystander", act


def _violations(test: TestResult, units: Mapping[str, str]) -> Iterator[tuple[float, str, str]]:
    for name, result in test.requirements.items():
        for violation in result.violations:
            yield violation.time_s, name, f"FAILED {violation_line(violation, units)}"


def _list_undecided_events(test: TestResult) -> Iterator[tuple[float, str, str]]:
    """The triggers that are undecided at the end of the run; without them it would look passed."""
    for name, spans in test.timeline.triggers.items() if test.timeline else ():
        for span in spans.split():
            if span.endswith("?"):
                begin_s = span.removesuffix("?").rpartition("-")[0]
                yield test.timeline.end_s if test.timeline else 0.0, name, f"pending, triggered at {begin_s} s"
