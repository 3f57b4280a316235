"""What is shown of causes: in the terminal first of all, a view of the page, and properties of JUnit's file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from msgspec import to_builtins

from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.diagnosis.records import CAUSES, DIAGNOSIS, LINES, Cause, SuspiciousPlace
from pytest_hricdv.report.explanation import replay_command
from pytest_hricdv.report.formatting import Line, Style, and_more, fit, fit_path, plural, width, wrap
from pytest_hricdv.report.tests_view import anchor
from pytest_hricdv.report.view import FailureCause, FailureCauses, PageSection, View
from pytest_hricdv.results.baseline_diff import NEW_CAUSE
from pytest_hricdv.results.model import Report, TestResult

MAX_LINES = 8
"""Of a cause in the terminal."""

_MAX_ACTIONS = 3
MAX_PLACES = 2
_MAX_REQUIREMENTS = 8
_MAX_WRAPPED = 2
"""Lines of a sentence; chosen: then all of a cause is in `MAX_LINES`."""


def cause_lines(
    number: int,
    cause: Cause,
    options: Sequence[str],
    columns: int | None,
    status: str = "",
    most_places: int = MAX_PLACES,
) -> tuple[Line, ...]:
    """What it is, where, what decides, its shortest test, and the command that runs this again.

    Args:
        number: of the cause, from 1.
        options: of the session, as far as a replay needs them.
        columns: of the terminal; None where lines may have any width.
        most_places: so many statements are named.
        status: as `new`, compared with a baseline; empty where there is nothing to say.
    """
    places = cause.likely_locations[:most_places]
    lines = [
        *_sentence(title_of(number, cause, status), columns, "  "),
        *(_place(place, columns) for place in places),
        *([] if places or not cause.stood else [_describe_nodes(cause, columns)]),
    ]
    style: Style = "warn" if cause.is_known else "bad"
    shown = [Line(text, style if number == 0 else "plain") for number, text in enumerate(lines)]
    if cause.deciding_change:
        shown += [Line(text) for text in _sentence(f"  {cause.deciding_change}", columns, "    ")]
    shown += [Line(_shortest(cause, columns))]
    if command := replay_of(cause, options):
        shown.append(Line(f"  {visible(command)}", "dim"))
    while len(shown) > MAX_LINES:  # the second place, or the end of a sentence: all is on the page
        del shown[2]
    return tuple(shown)


def title_of(number: int, cause: Cause, status: str = "") -> str:
    """`cause 1 (3f2a91bc, new): R29, R21 in 6 tests, first in the state releasing`."""
    return f"cause {number} ({cause.id}{f', {status}' if status else ''}): {summary_of(cause)}"


def summary_of(cause: Cause) -> str:
    """`R29, R21 in 6 tests, first in the state releasing`."""
    names, left = cause.requirements[:_MAX_REQUIREMENTS], len(cause.requirements) - _MAX_REQUIREMENTS
    listed = ", ".join(names) + and_more(max(left, 0))
    where = f", first in the state {cause.state}" if cause.state else ""
    many = plural(len(cause.tests), "test")
    if (share := cause.probability) is not None:
        percent = 100 * share.failing / share.runs
        many = f"{share.failing:,} of {share.runs:,} runs, {percent:.2f} % ({share.low:.2f} to {share.high:.2f})"
    return f"{listed} in {many}{where}{' (known)' if cause.is_known else ''}"


def replay_of(cause: Cause, options: Sequence[str]) -> str:
    """The command that runs its shortest test again; empty where this has no file."""
    return replay_command(cause.replay, options) if cause.replay else ""


def _place(place: SuspiciousPlace, columns: int | None) -> str:
    """`  at file:line in function: the line`; of what is too long, the statement is cut before the place."""
    where, shown = visible(f"{place.file}:{place.line}"), place.experiment or f"{place.score:.2f}"
    rest = visible(f" in {place.function} ({shown}): {place.text}")
    if columns is None:
        return f"  at {where}{rest}"
    return fit(f"  at {fit_path(where, max(columns - 5, 8))}{rest}", columns)


def _describe_nodes(cause: Cause, columns: int | None) -> str:
    """`  the code was at file:line in function; ...`: what is certain where no statement is likely."""
    text = visible(f"  the code was at {'; '.join(cause.stood)}")
    return text if columns is None else fit(text, columns)


def _shortest(cause: Cause, columns: int | None) -> str:
    """The test, whose id is not cut, and its first actions, as far as there is room."""
    kind = "what is left of" if cause.is_shrunk else "shortest test"
    start = visible(f"  {kind} {cause.minimal_of or cause.tests[0]}")
    for count in range(min(_MAX_ACTIONS, len(cause.minimal)), 0, -1):
        left = len(cause.minimal) - count
        text = f"{start}: {visible('; '.join(cause.minimal[:count]))}{f'; ... {left} more' if left else ''}"
        if columns is None or width(text) <= columns:
            return text
    return start


def _sentence(text: str, columns: int | None, indent: str) -> Iterator[str]:
    """A sentence in at most `_MAX_WRAPPED` lines, the later ones indented."""
    shown = visible(text)
    if columns is None or width(shown) <= columns:
        yield shown
        return
    begin = shown[: len(shown) - len(shown.lstrip())]
    lines = wrap(shown.split(), columns - len(indent))
    kept = lines[:_MAX_WRAPPED]
    if len(lines) > len(kept):
        kept[-1] = fit(f"{kept[-1]} {lines[len(kept)]}", columns - len(indent))
    yield from (f"{indent if number else begin}{line}" for number, line in enumerate(kept))


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
        options = report.rerun_options.options
        status = _status(report)
        places = MAX_PLACES if len(causes) < _MANY else 1
        blocks = (
            FailureCause(
                label=f"cause {number}",
                title=title_of(number, cause, status.get(cause.id, "")),
                lines=cause_lines(number, cause, options, columns, status.get(cause.id, ""), places),
                tests=tuple(nodeid for name in cause.tests for nodeid in nodeids.get(name, ())),
                place=next(((place.file, place.line) for place in cause.likely_locations), None),
                is_known=cause.is_known,
                anchor=f"cause-{cause.id}",
                decides=cause.deciding_change,
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
        commands = {cause.id: replay_of(cause, report.rerun_options.options) for cause in causes}
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
            lines = cause_lines(number, cause, report.rerun_options.options, None)
            yield f"hri.cause.{number}", "; ".join(line.text.strip() for line in lines)


VIEW = DiagnosisView()


def _neighbour(report: Report, cause: Cause, test: TestResult) -> dict[str, Any] | None:
    """The run that passes, of the test that it is a neighbour of; of another test of the cause, where to find it."""
    decision = cause.minimal_pair
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
    ended = {"done": "", "runs": "; the budget is used up", "interrupted": "; interrupted"}[diagnosis.end_reason]
    # With nothing to compare with, all that failing runs executed gets the highest scores.
    alone = (
        "" if any(test.outcome == "passed" for test in report.tests) else "; no test passed: scores compare with none"
    )
    runs = plural(diagnosis.runs, "run")
    return f"causes: by association over all tests, and {runs} of experiments{ended}{alone}"
