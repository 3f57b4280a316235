"""Exports: files for other tools, written after the session. Registered in the controlling process only."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from pytest_hricdv._base.message import visible
from pytest_hricdv.report import EXPORT_FORMATS, ci_formats, files
from pytest_hricdv.report.annotations import Place, annotation_commands
from pytest_hricdv.report.exported_files import ExportTargets, write_exports
from pytest_hricdv.report.failing_tests import FailingTests
from pytest_hricdv.results.codec import ReportError
from pytest_hricdv.results.model import Report
from pytest_hricdv.session.pytest_options import runs_tests, say_without_terminal
from pytest_hricdv.session.usage import usage_error

if TYPE_CHECKING:
    from pytest_hricdv.session.reporting import Reporting

_ID = "hri.id"
"""The property by which an element of the JUnit file is known to be of a generated test."""


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


class Exporting:
    """Writes the files after the report, also of a stopped session; a file that cannot be written fails it."""

    def __init__(self, config: pytest.Config, reporting: Reporting, targets: ExportTargets) -> None:
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
                for name, value in ci_formats.junit_suite_properties(report):
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
        report: of the session.
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
