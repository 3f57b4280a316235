"""What a session found out beside its suites' verdicts: replays, short failing tests, violations."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pytest_hricdv.report.figure import natural, plural, quantity, seconds
from pytest_hricdv.report.line import Line, visible
from pytest_hricdv.report.rerun import replay

_MAX_ACTIONS = 14
_ENDED = {
    "done": "",
    "runs": "; no runs left, so perhaps it can be shorter",
    "seconds": "; no time left, so perhaps it can be shorter",
    "interrupted": "; interrupted, so perhaps it can be shorter",
}


def replay_header(testbench: str, files: int) -> str:
    """The line in pytest's header: `hri: table-assembly, replay of 1 test`."""
    return visible(f"hri: {testbench}, replay of {plural(files, 'test')}")


def lines(report: Mapping[str, Any]) -> Iterator[Line]:
    """The lines of the summary. They are not cut: they hold commands, which have to be whole to be of use."""
    options = report.get("rerun", {}).get("options", ())
    for test in report["tests"]:
        if test.get("replayed"):
            yield _replayed(test["id"], test["replayed"])
    for test in report["tests"]:
        for requirement in sorted(test.get("shrunk", ()), key=natural):
            yield from _shrunk(requirement, test["id"], test["shrunk"][requirement], options, test.get("replay"))
    searched = report.get("search", {})
    for requirement in sorted(searched, key=natural):
        yield from _searched(requirement, searched[requirement], options)


def _replayed(test: str, replayed: Mapping[str, Any]) -> Line:
    if replayed["same"]:
        return Line(visible(f"replay of {test}: the same run, to the bit"), "ok")
    changed: list[str] = replayed["changed"]
    if changed:
        return Line(visible(f"replay of {test}: another run than before, for {', '.join(changed)}"), "warn")
    return Line(visible(f"replay of {test}: another run than before, and nobody knows why"), "bad")


def _shrunk(
    requirement: str, test: str, shrunk: Mapping[str, Any], options: Sequence[str], file: str | None
) -> Iterator[Line]:
    cost = f"{plural(shrunk['runs'], 'run')}, {seconds(shrunk['wall_s'])}{_ENDED[shrunk['ended']]}"
    name = f"{requirement} of {test}"
    if shrunk["note"]:
        yield Line(visible(f"{name} was not shrunk: {shrunk['note']}"), "warn")
        return
    actions = shrunk.get("concrete", shrunk["abstract"])
    what = f"{plural(shrunk['actions_before'], 'action')} to {len(shrunk['abstract'])}"
    yield Line(visible(f"{name} shrunk from {what}, for {' & '.join(shrunk['reason'])} ({cost}):"), "title")
    yield from (Line(visible(f"  {action}")) for action in actions[:_MAX_ACTIONS] or ["nothing"])
    if len(actions) > _MAX_ACTIONS:
        yield Line(f"  ... and {plural(len(actions) - _MAX_ACTIONS, 'more action')}")
    file = shrunk["replay"] or file
    if file:
        yield Line(visible(f"  {replay(file, options)}"), "dim")


def _searched(requirement: str, searched: Mapping[str, Any], options: Sequence[str]) -> Iterator[Line]:
    status = searched["status"]
    if status == "never triggered":
        yield Line(visible(f"search for a violation of {requirement}: no test triggers it, so nothing was run"), "warn")
        return
    if status == "violated by the suite":
        yield Line(
            visible(f"search for a violation of {requirement}: not needed, {searched['test']} violates it"), "dim"
        )
        return
    cut = "; interrupted" if searched["ended"] == "interrupted" else ""
    cost = f"{plural(searched['runs'], 'run')}, {seconds(searched['wall_s'])}{cut}"
    before, margin = (_margin(searched[key]) for key in ("suite_margin", "margin"))
    if status == "not violated":
        text = f"no violation of {requirement} found: margin {margin}, {before} in the suite"
        yield Line(visible(f"{text}; nearest was a variant of {searched['test']} ({cost})"), "ok")
        return
    yield Line(
        visible(f"violation of {requirement} found: a variant of {searched['test']}, margin {margin} ({cost})"), "bad"
    )
    if searched["replay"]:
        yield Line(visible(f"  {replay(searched['replay'], options)}"), "dim")
    if "shrunk" in searched:
        yield from _shrunk(requirement, searched["id"], searched["shrunk"], options, searched["replay"])


def _margin(margin: float | None) -> str:
    return "none (nothing is compared)" if margin is None else quantity(margin)
