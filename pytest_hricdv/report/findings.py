"""Findings of a session beside its suites' verdicts: replays, shrunk tests, and violations found by a search."""

from collections.abc import Iterator, Sequence

from pytest_hricdv.report.formatting import Line, natural, plural, quantity, seconds, visible
from pytest_hricdv.report.rerun import replay_command
from pytest_hricdv.results.model import ReplayComparison, Report, SearchResult, ShrunkTest

_MAX_ACTIONS = 14
_ENDED = {
    "done": "",
    "runs": "; the budget of runs is used up, a shorter test may exist",
    "seconds": "; the budget of time is used up, a shorter test may exist",
    "interrupted": "; interrupted, a shorter test may exist",
}


def replay_header(testbench: str, files: int) -> str:
    """The line in pytest's header: `hri: table-assembly, replay of 1 test`."""
    return visible(f"hri: {testbench}, replay of {plural(files, 'test')}")


def findings(report: Report) -> Iterator[Line]:
    """Lines for the terminal. They are not cut to its width: a command has to be complete to be used."""
    options = report.rerun.options
    for test in report.tests:
        if test.replayed:
            yield _replayed(test.id, test.replayed)
    for test in report.tests:
        for requirement in sorted(test.shrunk, key=natural):
            yield from _shrunk(requirement, test.id, test.shrunk[requirement], options, test.replay)
    for requirement in sorted(report.search, key=natural):
        yield from _searched(requirement, report.search[requirement], options)


def _replayed(test: str, replayed: ReplayComparison) -> Line:
    start = visible(f"replay of {test}: ")
    if replayed.same:
        return Line(f"{start}the same run, to the bit", "ok")
    if replayed.changed:
        return Line(f"{start}differs from the recording: {visible(', '.join(replayed.changed))}", "warn")
    return Line(f"{start}differs from the recording; cause unknown", "bad")


def _shrunk(
    requirement: str, test: str, shrunk: ShrunkTest, options: Sequence[str], file: str | None
) -> Iterator[Line]:
    name = f"{requirement} of {test}"
    if shrunk.note:
        yield Line(visible(f"{name} was not shrunk: {shrunk.note}"), "warn")
        return
    cost = f"{plural(shrunk.runs, 'run')}, {seconds(shrunk.wall_s)}{_ENDED[shrunk.ended]}"
    size = f"{plural(shrunk.actions_before, 'action')} to {len(shrunk.abstract)}"
    yield Line(visible(f"{name} shrunk from {size}, for {' & '.join(shrunk.reason)} ({cost}):"), "title")
    yield from (Line(visible(f"  {action}")) for action in shrunk.concrete[:_MAX_ACTIONS] or ["nothing"])
    if len(shrunk.concrete) > _MAX_ACTIONS:
        yield Line(f"  ... and {plural(len(shrunk.concrete) - _MAX_ACTIONS, 'more action')}")
    file = shrunk.replay or file
    if file:
        yield Line(visible(f"  {replay_command(file, options)}"), "dim")


def _searched(requirement: str, searched: SearchResult, options: Sequence[str]) -> Iterator[Line]:
    search = f"search for a violation of {requirement}"
    interrupted = "; interrupted" if searched.ended == "interrupted" else ""
    cost = f"{plural(searched.runs, 'run')}, {seconds(searched.wall_s)}{interrupted}"
    before, margin = _margin(searched.suite_margin), _margin(searched.margin)
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


def _margin(margin: float | None) -> str:
    return "none (no value is compared)" if margin is None else quantity(margin)
