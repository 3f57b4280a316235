"""What a test shows in the reports of other plugins: its film, its timeline as text, a link; Allure, pytest-html."""

from __future__ import annotations

import base64
import contextlib
import os
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from pytest_hricdv._base import own_json as json
from pytest_hricdv._base.contained import file_inside
from pytest_hricdv._base.message import visible
from pytest_hricdv.report.files import PAGE_NAME
from pytest_hricdv.report.tests_view import anchor
from pytest_hricdv.report.view import views
from pytest_hricdv.report.violation_lines import violation_line
from pytest_hricdv.results.codec import decode
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.session.collection import ATTRIBUTE

if TYPE_CHECKING:
    from pytest_hricdv.session.collection import Collection

LINK = "pytest-hricdv"
TIMELINE = "timeline"
_SENDER_COLUMNS = 10
"""Of a timeline; chosen: names of nodes are about as long, and longer ones only shift their own line."""


class Attaching(ABC):
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


class AllureAttaching(Attaching):
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


class HtmlAttaching(Attaching):
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


def attaching(collection: Collection) -> Iterator[Attaching]:
    """One for each plugin that is installed and writes a report in this session."""
    config = collection.config
    results = config.getoption("allure_report_dir", None)
    if _is_loaded(config, "allure_pytest", "allure_pytest.plugin") and results:
        yield AllureAttaching(collection, Path(os.path.abspath(results)))
    page = config.getoption("htmlpath", None)
    if _is_loaded(config, "html", "pytest_html.plugin") and page:
        contained = bool(config.getoption("self_contained_html", False))
        yield HtmlAttaching(collection, Path(os.path.abspath(page)), self_contained=contained)


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
    """One line an event: time (s), who, what. A line says so where the run was not completed.

    Args:
        test: with its timeline.
        units: signal -> unit, for the values at violations.
    """
    if test.timeline is None:
        return "no timeline: the run was not completed\n"
    events = [*_messages(test), *_actions(test), *_violations(test, units), *_pending(test)]
    events.append((test.timeline.end_s, "", test.ended))
    lines = (
        f"{time_s:9.3f}  {sender:{_SENDER_COLUMNS}}  {event}".rstrip()
        for time_s, sender, event in sorted(events, key=lambda event: event[0])
    )
    return "".join(f"{visible(line)}\n" for line in lines)


def _messages(test: TestResult) -> Iterator[tuple[float, str, str]]:
    for text in test.timeline.messages if test.timeline else ():
        time_s, sender, topic, fields = text.split("\t", 3)
        said = ", ".join(f"{name} {value}" for name, value in json.loads(fields).items())
        yield float(time_s), sender, f"{topic} {said}".rstrip()


def _actions(test: TestResult) -> Iterator[tuple[float, str, str]]:
    for time_s, number in test.begun:
        yield time_s, f"action {number + 1}", test.abstract[number]
    for time_s, act in test.seen:
        yield time_s, "bystander", act


def _violations(test: TestResult, units: Mapping[str, str]) -> Iterator[tuple[float, str, str]]:
    for name, result in test.requirements.items():
        for violation in result.violations:
            yield violation.time_s, name, f"FAILED {violation_line(violation, units)}"


def _pending(test: TestResult) -> Iterator[tuple[float, str, str]]:
    """What was triggered and is undecided, as it would look passed: where the run ended."""
    for name, spans in test.timeline.triggers.items() if test.timeline else ():
        for span in spans.split():
            if span.endswith("?"):
                begin_s = span.removesuffix("?").rpartition("-")[0]
                yield test.timeline.end_s if test.timeline else 0.0, name, f"pending, triggered at {begin_s} s"
