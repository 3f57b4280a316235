"""`View`: by it, a feature shows its part of a report in the terminal, on the page and in formats of CI services.

The core's views call each of `views`; `report.__main__` adds the `ReportCommand`s of features to `hricdv report`.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from pytest_hricdv.registry import offers

if TYPE_CHECKING:  # `results.model` is extended by features, some of which have their view in the same module
    from pytest_hricdv.report.formatting import Line
    from pytest_hricdv.results.model import Report, TestResult

Place = Literal["causes", "requirements", "in closure", "in summary", "further"]
"""The place of a section: its own entry in the navigation, next to the requirements, in the closure view, in the
summary, or next to other views that only some reports have."""


@dataclass(frozen=True)
class PageSection:
    """A section of the page.

    Args:
        id: the id of its element, and of its address.
        title: its title in the navigation; empty if it is part of another view.
        template: its file in the feature's folder `page`, as `PART/NAME.html.jinja`.
        values: what the template reads as `part`.
        place: where it stands.
        headline: the headline of the page's summary, a link to the section; empty for none.
        remark: a sentence after it.
    """

    id: str
    title: str
    template: str
    values: Mapping[str, Any]
    place: Place = "further"
    headline: str = ""
    remark: str = ""


@dataclass(frozen=True)
class FailureCause:
    """A cause of failures.

    Args:
        label: its name in a line on a test, as `cause 1`.
        title: a line that stands alone.
        lines: the terminal's text on it, the title first.
        tests: node ids, the best example first.
        place: the file and line of the code where it probably is; None if nobody knows.
        is_known: whether all of its violations are known ones.
        anchor: id of its element on the page; empty if it has none.
        decides: what makes the difference between failing and passing; empty if nobody knows.
    """

    label: str
    title: str
    lines: tuple[Line, ...]
    tests: tuple[str, ...]
    place: tuple[str, int] | None = None
    is_known: bool = False
    anchor: str = ""
    decides: str = ""


@dataclass(frozen=True)
class FailureCauses:
    """The causes of a report's failures: how many there are, each of them, and their evidence."""

    headline: str
    causes: tuple[FailureCause, ...]
    remark: str = ""


@dataclass(frozen=True)
class SheetTable:
    """A table of the sheet to sign: its title, what stands above it, the heads of columns, and rows of texts."""

    title: str
    note: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


@dataclass(frozen=True)
class RequirementNote:
    """A sentence on a requirement's page: `before`, then `status` in bold, then `after`; and a command to copy."""

    before: str
    status: str = ""
    after: str = ""
    command: str = ""


class View:
    """The view of a feature, its `VIEW`; by default it shows nothing.

    Attributes:
        name: the name of the feature's folder.
        scripts: files in its folder `page`, without `.js`, which the page has before the core's last one.
    """

    name = ""
    scripts: tuple[str, ...] = ()

    def lines(self, report: Report, columns: int) -> Iterable[Line]:
        """Lines of the terminal's summary above the totals."""
        return ()

    def file_lines(self, report: Report, columns: int) -> Iterable[Line]:
        """Lines of the terminal's summary below the totals, on files next to the report."""
        return ()

    def causes(self, report: Report, columns: int | None) -> FailureCauses | None:
        """The causes of its failures, which the terminal shows first; None if no feature looked for them.

        Args:
            columns: number of columns of the terminal; None where lines may have any width.
        """
        return None

    def findings(self, report: Report) -> Iterable[Line]:
        """Lines of the terminal after the summary, of any width: commands must not be cut."""
        return ()

    def section(self, report: Report) -> PageSection | None:
        """The section of the page; None if the report has nothing of this feature."""
        return None

    def data(self, report: Report) -> Mapping[str, Any]:
        """Plain data for the page's scripts, by keys that no other feature and not the core has."""
        return {}

    def of_test(self, report: Report, test: TestResult) -> Mapping[str, Any]:
        """Plain data on a test for its page, likewise."""
        return {}

    def facts(self, test: TestResult) -> Mapping[str, str]:
        """Facts on a test, for the table on its page; an empty string is not shown."""
        return {}

    def of_requirement(self, report: Report, name: str) -> RequirementNote | None:
        """The part of a requirement's page; None for nothing."""
        return None

    def of_sheet(self, report: Report) -> SheetTable | None:
        """The part of the sheet to sign; None for nothing."""
        return None

    def aim(self, report: Report) -> str:
        """The command that aims at what no test of the report covers; empty if this feature has none."""
        return ""

    def markdown(self, report: Report) -> Iterable[str]:
        """Paragraphs of a CI job's summary, not escaped."""
        return ()

    def properties(self, report: Report) -> Iterable[tuple[str, object]]:
        """The properties of the JUnit file's test suite."""
        return ()

    def total_simulated_s(self, report: Report) -> float | None:
        """Simulated time of all runs that the report is of, where it does not list all of them as tests; else None."""
        return None

    def test_noun(self, report: Report) -> str:
        """The noun for the listed tests, if the report does not list all runs; empty otherwise."""
        return ""

    def pictures(self, test: TestResult) -> Iterable[tuple[str, str]]:
        """Name and file, relative to the report, of what reports of other plugins attach to a test."""
        return ()


def views() -> tuple[View, ...]:
    """The views of all features, in the order in which they are shown."""
    return offers("view", "VIEW")


def failure_causes(report: Report, columns: int | None = None) -> FailureCauses | None:
    """The causes of failures by the first feature that looked for them; None if none has."""
    return next(filter(None, (view.causes(report, columns) for view in views())), None)


@dataclass(frozen=True)
class ReportCommand:
    """A command on reports, of `hricdv report`.

    Args:
        name: the name of the command.
        purpose: what it does, for `--help`.
        add_arguments: adds its arguments to its parser.
        do: does it; returns the exit status, and raises ReportError for a report that cannot be used.
    """

    name: str
    purpose: str
    add_arguments: Callable[[argparse.ArgumentParser], None]
    do: Callable[[argparse.Namespace], int]


def commands_of_features() -> tuple[ReportCommand, ...]:
    """The commands of all features."""
    return tuple(command for offered in offers("commands", "COMMANDS") for command in offered)
