"""What is shown of causes: in the terminal first of all, a view of the page, and a paragraph of a CI job's summary."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.diagnosis.records import CAUSES, DIAGNOSIS, Cause
from pytest_hricdv.report.explanation import replay_command
from pytest_hricdv.report.formatting import Line, plural
from pytest_hricdv.report.markdown_text import escaped
from pytest_hricdv.report.view import PageSection, View
from pytest_hricdv.results.model import Report

_MOST_LINES = 3
"""So many lines of the shortest test are in the terminal: a cause takes eight lines at most."""

_MOST_PLACES = 2
_MOST_REQUIREMENTS = 8


class DiagnosisView(View):
    """Causes of failures."""

    name = "diagnosis"

    def findings(self, report: Report) -> Iterator[Line]:
        """How many causes there are, then each of them."""
        causes = CAUSES.of(report)
        if not causes:
            return
        yield Line(headline(causes), "title")
        for number, cause in enumerate(causes, 1):
            yield from _lines(number, cause, report.rerun.options)
        if basis := _basis(report):
            yield Line(basis, "dim")

    def section(self, report: Report) -> PageSection | None:
        """A table of the causes."""
        causes = CAUSES.of(report)
        if not causes:
            return None
        nodeids = {test.id: test.nodeid for test in report.tests}
        commands = {cause.id: _replay(cause, report.rerun.options) for cause in causes}
        values = {"causes": causes, "nodeids": nodeids, "commands": commands, "basis": _basis(report)}
        return PageSection(
            "causes", "Causes", "diagnosis/causes.html.jinja", values, place="after suites", headline=headline(causes)
        )

    def markdown(self, report: Report) -> Iterator[str]:
        """One paragraph a cause."""
        for number, cause in enumerate(CAUSES.of(report), 1):
            place = next((f", at {place.file}:{place.line}" for place in cause.places), "")
            yield f"**Cause {number}**: {escaped(_what(cause) + place)}"


VIEW = DiagnosisView()


def headline(causes: Sequence[Cause]) -> str:
    """`24 tests fail for 3 causes`, and how many of them are known."""
    tests = {test for cause in causes for test in cause.tests}
    declared = sum(cause.is_known for cause in causes)
    verb = "fails" if len(tests) == 1 else "fail"
    text = f"{plural(len(tests), 'test')} {verb} for {plural(len(causes), 'cause')}"
    return f"{text}, {declared} of them known" if declared else text


def _lines(number: int, cause: Cause, options: Sequence[str]) -> Iterator[Line]:
    yield Line(visible(f"cause {number}: {_what(cause)}"), "warn" if cause.is_known else "bad")
    for place in cause.places[:_MOST_PLACES]:
        yield Line(visible(f"  at {place.file}:{place.line} in {place.function}, {place.score:.2f}: {place.text}"))
    if cause.decides:
        yield Line(visible(f"  {cause.decides}"))
    actions = "; ".join(cause.minimal[:_MOST_LINES])
    more = f"; ... {len(cause.minimal) - _MOST_LINES} more" if len(cause.minimal) > _MOST_LINES else ""
    yield Line(visible(f"  shortest test {cause.tests[0]}: {actions}{more}"))
    if command := _replay(cause, options):
        yield Line(visible(f"  {command}"), "dim")


def _what(cause: Cause) -> str:
    """`R29, R21 in 6 tests, first in the state releasing`."""
    names, left = cause.requirements[:_MOST_REQUIREMENTS], len(cause.requirements) - _MOST_REQUIREMENTS
    listed = ", ".join(names) + (f" and {left} more" if left > 0 else "")
    where = f", first in the state {cause.state}" if cause.state else ""
    return f"{listed} in {plural(len(cause.tests), 'test')}{where}{' (known)' if cause.is_known else ''}"


def _replay(cause: Cause, options: Sequence[str]) -> str:
    return replay_command(cause.replay, options) if cause.replay else ""


def _basis(report: Report) -> str:
    diagnosis = DIAGNOSIS.of(report)
    if diagnosis is None:
        return ""
    ended = {
        "done": "",
        "runs": "; the budget is used up, --hri-diagnose=N allows more",
        "interrupted": "; interrupted",
    }[diagnosis.ended]
    return f"causes: by association over all tests, and {plural(diagnosis.runs, 'run')} of experiments{ended}"
