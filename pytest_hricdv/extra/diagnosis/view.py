"""What is shown of causes: in the terminal first of all, a view of the page, and properties of JUnit's file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from msgspec import to_builtins

from pytest_hricdv.extra.diagnosis.cause_lines import MOST_PLACES, cause_lines, replay_of, title_of
from pytest_hricdv.extra.diagnosis.records import CAUSES, DIAGNOSIS, LINES, Cause
from pytest_hricdv.report.formatting import plural
from pytest_hricdv.report.tests_view import anchor
from pytest_hricdv.report.view import FailureCause, FailureCauses, PageSection, View
from pytest_hricdv.results.baseline_diff import NEW_CAUSE
from pytest_hricdv.results.model import Report, TestResult

_MANY = 3
"""Of so many causes, each has one statement in the terminal (chosen: all of them stay on a screen)."""


class DiagnosisView(View):
    """Causes of failures."""

    name = "diagnosis"
    scripts = ("code_panel", "passing_neighbour")

    def causes(self, report: Report, columns: int | None) -> FailureCauses | None:
        """How many causes there are, then each of them."""
        causes = CAUSES.of(report)
        if not causes:
            return None
        nodeids: dict[str, list[str]] = {}
        for test in report.tests:
            nodeids.setdefault(test.id, []).append(test.nodeid)
        options = report.rerun.options
        status = _status(report)
        places = MOST_PLACES if len(causes) < _MANY else 1
        blocks = (
            FailureCause(
                label=f"cause {number}",
                title=title_of(number, cause, status.get(cause.id, "")),
                lines=cause_lines(number, cause, options, columns, status.get(cause.id, ""), places),
                tests=tuple(nodeid for name in cause.tests for nodeid in nodeids.get(name, ())),
                place=next(((place.file, place.line) for place in cause.places), None),
                is_known=cause.is_known,
                anchor=f"cause-{cause.id}",
                decides=cause.decides,
            )
            for number, cause in enumerate(causes, 1)
        )
        return FailureCauses(headline(causes), tuple(blocks), _basis(report))

    def section(self, report: Report) -> PageSection | None:
        """A table of the causes."""
        causes = CAUSES.of(report)
        if not causes:
            return None
        nodeids = {test.id: test.nodeid for test in report.tests}
        commands = {cause.id: replay_of(cause, report.rerun.options) for cause in causes}
        values = {"causes": causes, "nodeids": nodeids, "commands": commands, "basis": _basis(report)}
        return PageSection(
            "causes", "Causes", "diagnosis/causes.html.jinja", values, place="causes", headline=headline(causes)
        )

    def of_test(self, report: Report, test: TestResult) -> dict[str, Any]:
        """The lines that its run executed, and the nearest passing run."""
        lines = LINES.of(test)
        cause = next((cause for cause in CAUSES.of(report) if test.id in cause.tests), None)
        return {
            "lines": None if lines is None else to_builtins(lines),
            "neighbour": None if cause is None or not test.fails else _neighbour(report, cause, test),
        }

    def properties(self, report: Report) -> Iterator[tuple[str, object]]:
        """How many causes, and each of them in a line."""
        causes = CAUSES.of(report)
        if causes:
            yield "hri.causes", len(causes)
        for number, cause in enumerate(causes, 1):
            lines = cause_lines(number, cause, report.rerun.options, None)
            yield f"hri.cause.{number}", "; ".join(line.text.strip() for line in lines)


VIEW = DiagnosisView()


def _neighbour(report: Report, cause: Cause, test: TestResult) -> dict[str, Any] | None:
    """The run that passes, of the test that it is a neighbour of; of another test of the cause, where to find it."""
    decision = cause.decision
    if decision is None or decision.neighbour is None:
        return None
    owner = cause.minimal_of if cause.is_shrunk else decision.test
    if test.id != owner:
        of = next((other.nodeid for other in report.tests if other.id == owner), None)
        return None if of is None else {"of": owner, "anchor": anchor(of), "words": decision.words}
    return {
        "words": decision.words,
        "is_shrunk": cause.is_shrunk,
        "abstract": decision.neighbour.abstract,
        "begun": decision.neighbour.begun,
        "timeline": to_builtins(decision.neighbour.timeline),
        "lines": to_builtins(decision.neighbour.lines),
    }


def headline(causes: Sequence[Cause]) -> str:
    """`24 tests fail for 3 causes`, and how many of them are known."""
    tests = {test for cause in causes for test in cause.tests}
    declared = sum(cause.is_known for cause in causes)
    verb = "fails" if len(tests) == 1 else "fail"
    text = f"{plural(len(tests), 'test')} {verb} for {plural(len(causes), 'cause')}"
    return f"{text}, {declared} of them known" if declared else text


def _status(report: Report) -> dict[str, str]:
    """Id -> whether the baseline has it, where the report was compared with one that knows causes."""
    differences = report.gates.differences if report.gates is not None else ()
    new = {name for difference in differences if difference.what == NEW_CAUSE for name in difference.items}
    return dict.fromkeys(new, "new")


def _basis(report: Report) -> str:
    diagnosis = DIAGNOSIS.of(report)
    if diagnosis is None:
        return ""
    ended = {"done": "", "runs": "; the budget is used up", "interrupted": "; interrupted"}[diagnosis.ended]
    # With nothing to compare with, all that failing runs executed gets the highest scores.
    alone = (
        "" if any(test.outcome == "passed" for test in report.tests) else "; no test passed: scores compare with none"
    )
    runs = plural(diagnosis.runs, "run")
    return f"causes: by association over all tests, and {runs} of experiments{ended}{alone}"
