"""The navigation of the page: at most seven entries, whatever a report has; an entry with several views lists them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from pytest_hricdv.report.formatting import plural
from pytest_hricdv.report.view import PageSection
from pytest_hricdv.results.model import Report


@dataclass(frozen=True)
class Link:
    """A view of the page: the id of its element, which is its address, and its title."""

    id: str
    title: str


@dataclass(frozen=True)
class Area:
    """An entry of the navigation: its title, and its views, the first of which it opens."""

    title: str
    links: tuple[Link, ...]


def areas(report: Report, sections: Sequence[PageSection]) -> tuple[Area, ...]:
    """The entries in their order.

    Args:
        report: whose page it is.
        sections: of optional parts; those without a title are parts of other views.
    """
    return tuple(area for area in _areas(report, sections) if area.links)


def _areas(report: Report, sections: Sequence[PageSection]) -> Iterator[Area]:
    further = _links(sections, "further")
    yield Area("Summary", (Link("summary", "Summary"),))
    yield Area("Causes", _links(sections, "causes"))
    yield Area("Tests", (Link("tests", "Tests"),))
    yield Area("Requirements", (Link("requirements", "Requirements"), *_links(sections, "requirements")))
    yield Area("Coverage", (Link("closure", "Closure"), *_coverage(report)))
    # One view needs no name above it.
    yield Area(further[0].title if len(further) == 1 else "Further", further)
    yield Area("Sheet", (Link("sheet", "Sheet to sign"),))


def _coverage(report: Report) -> Iterator[Link]:
    yield Link("code", "Code")
    if report.models:
        yield Link("plans", "Plans")
    if report.cross_products:
        yield Link("cross", "Cross products")
    yield Link("suites", suites_title(report))


def suites_title(report: Report) -> str:
    """Of the view of suites: there is nothing to compare one with."""
    return "Suites compared" if len(report.suites) != 1 else "Growth"


def suites_heading(report: Report) -> str:
    """`Suite rl, 134 tests: how coverage grew`, or `Suites compared`."""
    if len(report.suites) != 1:
        return "Suites compared"
    return f"Suite {report.suites[0].name}, {plural(report.suites[0].tests, 'test')}: how coverage grew"


def _links(sections: Sequence[PageSection], place: str) -> tuple[Link, ...]:
    return tuple(Link(section.id, section.title) for section in sections if section.place == place and section.title)
