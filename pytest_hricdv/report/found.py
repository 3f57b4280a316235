"""What a session found out beside its suites' verdicts: whether replays were the same run."""

from collections.abc import Iterator, Mapping
from typing import Any

from pytest_hricdv.report.figure import plural
from pytest_hricdv.report.line import Line, visible


def replay_header(testbench: str, files: int) -> str:
    """The line in pytest's header: `hri: table-assembly, replay of 1 test`."""
    return visible(f"hri: {testbench}, replay of {plural(files, 'test')}")


def lines(report: Mapping[str, Any]) -> Iterator[Line]:
    """The lines of the summary. They are not cut: they hold commands, which have to be whole to be of use."""
    for test in report["tests"]:
        if test.get("replayed"):
            yield _replayed(test["id"], test["replayed"])


def _replayed(test: str, replayed: Mapping[str, Any]) -> Line:
    if replayed["same"]:
        return Line(visible(f"replay of {test}: the same run, to the bit"), "ok")
    changed: list[str] = replayed["changed"]
    if changed:
        return Line(visible(f"replay of {test}: another run than before, for {', '.join(changed)}"), "warn")
    return Line(visible(f"replay of {test}: another run than before, and nobody knows why"), "bad")
