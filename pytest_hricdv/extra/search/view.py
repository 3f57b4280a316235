"""`SearchView` shows shrunk tests and searches for violations in a report."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.search.records import SEARCH, SHRUNK, SearchResult, ShrunkTest
from pytest_hricdv.generate.actors import actors_of
from pytest_hricdv.report.explanation import replay_command
from pytest_hricdv.report.formatting import Line, by_requirement, enumerate_names, plural, quantity, seconds
from pytest_hricdv.report.view import RequirementNote, View
from pytest_hricdv.report.violations import margin_text, margin_unit
from pytest_hricdv.results.model import Report, TestResult

_MAX_ACTIONS = 14
_SHRINKING_ENDED = {
    "done": "",
    "runs": "; the budget of runs is used up, a shorter test may exist",
    "seconds": "; the budget of time is used up, a shorter test may exist",
    "interrupted": "; interrupted, a shorter test may exist",
}


class SearchView(View):
    """Shrunk tests and what searches found: commands to run them, and notes on tests and requirements."""

    name = "search"
    scripts = ("shrunk",)

    def findings(self, report: Report) -> Iterator[Line]:
        """The shrunk tests by test and requirement, each with the command that runs it."""
        options = report.rerun_options.options
        for test in report.tests:
            shrunk = SHRUNK.of(test)
            for requirement in sorted(shrunk, key=by_requirement):
                yield from _shrunk(requirement, test.id, shrunk[requirement], options, test.replay)
        results = SEARCH.of(report)
        for requirement in sorted(results, key=by_requirement):
            yield from _search_lines(requirement, results[requirement], options, margin_unit(report, requirement))

    def of_test(self, report: Report, test: TestResult) -> dict[str, Any]:
        """What it was shrunk to, by requirement."""
        return {"shrunk": [_plain(name, shrunk, report) for name, shrunk in sorted(SHRUNK.of(test).items())]}

    def of_requirement(self, report: Report, name: str) -> RequirementNote | None:
        """How close a search came to violating it."""
        result = SEARCH.of(report).get(name)
        if result is None:
            return None
        near = "" if result.margin is None else f", least margin found {quantity(result.margin)} "
        near += margin_unit(report, name) if near else ""
        command = replay_command(result.replay, report.rerun_options.options) if result.replay else ""
        return RequirementNote(
            "A search for a violation: ", result.status, f"{near}, {plural(result.runs, 'run')}.", command
        )


VIEW = SearchView()


def _plain(requirement: str, shrunk: ShrunkTest, report: Report) -> dict[str, Any]:
    return {
        "requirement": requirement,
        "from": shrunk.actions_before,
        "abstract": shrunk.abstract,
        "note": shrunk.note,
        "takes": ". ".join(filter(None, [_takes(shrunk).capitalize(), "; ".join(shrunk.course)])),
        "rerun": replay_command(shrunk.replay, report.rerun_options.options) if shrunk.replay else "",
    }


def _shrunk(
    requirement: str, test: str, shrunk: ShrunkTest, options: Sequence[str], file: str | None
) -> Iterator[Line]:
    name = f"{requirement} of {test}"
    if shrunk.note:
        yield Line(visible(f"{name} was not shrunk: {shrunk.note}"), "warn")
        return
    cost = f"{plural(shrunk.runs, 'run')}, {seconds(shrunk.wall_s)}{_SHRINKING_ENDED[shrunk.end_reason]}"
    size = f"{plural(shrunk.actions_before, 'action')} to {len(shrunk.abstract)}"
    yield Line(visible(f"{name} shrunk from {size}, for {' & '.join(shrunk.reason)} ({cost}):"), "title")
    yield from (Line(visible(f"  {action}")) for action in shrunk.concrete[:_MAX_ACTIONS] or ["nothing"])
    if len(shrunk.concrete) > _MAX_ACTIONS:
        yield Line(f"  ... and {plural(len(shrunk.concrete) - _MAX_ACTIONS, 'more action')}")
    if takes := _takes(shrunk):
        yield Line(visible(f"  {takes}"))
    if shrunk.course:
        yield Line(visible(f"  {'; '.join(shrunk.course)}"))
    file = shrunk.replay or file
    if file:
        yield Line(visible(f"  {replay_command(file, options)}"), "dim")


def _takes(shrunk: ShrunkTest) -> str:
    """The actors that a failure needs, if there are several: without any one of them, it did not occur."""
    actors = actors_of(shrunk.abstract)
    if len(actors) < 2 or shrunk.end_reason != "done":
        return ""
    return f"needs {enumerate_names(actors)}: without the actions of any one of them, it does not fail this way"


def _search_lines(requirement: str, searched: SearchResult, options: Sequence[str], unit: str) -> Iterator[Line]:
    search = f"search for a violation of {requirement}"
    interrupted = "; interrupted" if searched.end_reason == "interrupted" else ""
    cost = f"{plural(searched.runs, 'run')}, {seconds(searched.wall_s)}{interrupted}"
    before, margin = _margin(searched.suite_margin, unit), _margin(searched.margin, unit)
    match searched.status:
        case "never triggered":
            yield Line(visible(f"{search}: no test triggers it, so nothing was run"), "warn")
        case "violated by the suite":
            yield Line(visible(f"{search}: not needed, {searched.test} violates it"), "dim")
        case "not violated":
            text = f"no violation of {requirement} found: margin {margin}, {before} in the suite"
            yield Line(visible(f"{text}; nearest was a variant of {searched.test} ({cost})"), "ok")
        case "violated":
            text = f"violation of {requirement} found: a variant of {searched.test}, margin {margin} ({cost})"
            yield Line(visible(text), "bad")
            if searched.replay:
                yield Line(visible(f"  {replay_command(searched.replay, options)}"), "dim")
            if searched.shrunk:
                yield from _shrunk(requirement, searched.id or "", searched.shrunk, options, searched.replay)


def _margin(margin: float | None, unit: str) -> str:
    return "none (no value is compared)" if margin is None else margin_text(margin, unit)
