"""What a session found out beside its suites' verdicts: whether replays were the same run, and short failing tests."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from pytest_hricdv.report.figure import natural, plural, seconds
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
            yield from _shrunk(requirement, test, test["shrunk"][requirement], options)


def _replayed(test: str, replayed: Mapping[str, Any]) -> Line:
    if replayed["same"]:
        return Line(visible(f"replay of {test}: the same run, to the bit"), "ok")
    changed: list[str] = replayed["changed"]
    if changed:
        return Line(visible(f"replay of {test}: another run than before, for {', '.join(changed)}"), "warn")
    return Line(visible(f"replay of {test}: another run than before, and nobody knows why"), "bad")


def _shrunk(
    requirement: str, test: Mapping[str, Any], shrunk: Mapping[str, Any], options: Sequence[str]
) -> Iterator[Line]:
    cost = f"{plural(shrunk['runs'], 'run')}, {seconds(shrunk['wall_s'])}{_ENDED[shrunk['ended']]}"
    name = f"{requirement} of {test['id']}"
    if shrunk["note"]:
        yield Line(visible(f"{name} was not shrunk: {shrunk['note']}"), "warn")
        return
    actions = shrunk["abstract"]
    what = f"{plural(shrunk['actions_before'], 'action')} to {len(actions)}"
    yield Line(visible(f"{name} shrunk from {what}, for {' & '.join(shrunk['reason'])} ({cost}):"), "title")
    yield from (Line(visible(f"  {action}")) for action in actions[:_MAX_ACTIONS] or ["nothing"])
    if len(actions) > _MAX_ACTIONS:
        yield Line(f"  ... and {plural(len(actions) - _MAX_ACTIONS, 'more action')}")
    file = shrunk["replay"] or test.get("replay")
    if file:
        yield Line(visible(f"  {replay(file, options)}"), "dim")
