"""`DiagnosisView`: shows causes first in the terminal, in a section of the page, and as JUnit properties.

The report calls it by way of `registry`. `cause_lines` returns the lines of one cause.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from msgspec import to_builtins
from msgspec.structs import replace

from pytest_hricdv._base.message import list_names, visible
from pytest_hricdv.extra.diagnosis.records import CAUSES, DIAGNOSIS, LINES, Cause, SuspiciousPlace
from pytest_hricdv.report.explanation import replay_command
from pytest_hricdv.report.formatting import Line, fit, plural, seconds, width, wrap
from pytest_hricdv.report.tests_view import anchor
from pytest_hricdv.report.view import FailureCause, FailureCauses, PageSection, View
from pytest_hricdv.report.violations import describe_violation, first_violation, order_failures, unit_of
from pytest_hricdv.results.gate_check import NEW_CAUSE
from pytest_hricdv.results.model import Report, TestResult

_MAX_REQUIREMENTS = 8  # in the title of a cause
_LABEL = 9
"""Number of columns of `  where  ` and the other labels in the terminal."""


def cause_lines(
    number: int, cause: Cause, report: Report, columns: int | None, status: str = "", *, is_first: bool = False
) -> tuple[Line, ...]:
    """Lines on a cause: what it is, where, why, what happened, and the command that repeats it.

    Args:
        number: the number of the cause, from 1.
        columns: number of columns of the terminal; None where lines may have any width.
        status: as `new`, compared with a baseline; empty if there is nothing to say.
        is_first: whether it is the first cause, which gets two lines where others get one.
    """
    most = 2 if is_first else 1
    title = title_of(number, cause if columns is None else replace(cause, state=""), status)
    if (
        columns
        and len(cause.requirements) == 1
        and (texts := report.requirements.get(cause.requirements[0]))
        and texts.title
    ):
        title += f": {texts.title}"
    lines = [
        Line(visible(title) if columns is None else fit(visible(title), columns), "warn" if cause.is_known else "bad")
    ]
    places = [f"{place.file}:{place.line}{_statement(place)}" for place in cause.likely_locations[:most]]
    then = f"in the state {cause.state}" if cause.state else "where the code was then"
    stood = [] if places or not cause.stood else [f"{'; '.join(cause.stood)}, {then}"]
    for text in (*places, *stood):
        lines += _label_lines("where", text, columns, 1)
    if cause.deciding_change:
        lines += _label_lines("why", cause.deciding_change, columns, most)
    for label, text in [*_story(cause, report, columns)][:most]:
        lines += _label_lines(label, text, columns, 1)
    if command := replay_of(cause, report.rerun_options.options):
        lines.append(Line(f"  again  {visible(command)}", "dim"))
    return tuple(lines)


def _label_lines(label: str, text: str, columns: int | None, most: int) -> Iterator[Line]:
    """A text behind its label, in a limited number of lines, the last of which is cut."""
    shown = visible(text)
    if columns is None:
        yield Line(f"  {label:5}  {shown}")
        return
    first, *later = wrap(shown.split(" "), columns - _LABEL)
    kept = [first, *later][:most]
    if len(later) >= most:
        kept[-1] = fit(f"{kept[-1]} {' '.join(later[most - 1 :])}", columns - _LABEL)
    for number, line in enumerate(kept):
        yield Line(f"  {'' if number else label:5}  {line}")


def _statement(place: SuspiciousPlace) -> str:
    """` in function (what shows it): the line`."""
    return f" in {place.function} ({place.experiment or f'{place.score:.2f}'}): {place.text}"


def _story(cause: Cause, report: Report, columns: int | None) -> Iterator[tuple[str, str]]:
    """The last actions before the violation, or all that is left of them; then what was seen in the recorded run."""
    name = cause.minimal_of or cause.tests[0]
    test = next((test for test in report.tests if test.id == name), None)
    failed = order_failures(test, () if report.strict else report.known_violations) if test else []
    mine = next((requirement for requirement in failed if requirement in cause.requirements), "")
    violation = first_violation(test.requirements[mine]) if test and mine else None
    actions, end = list(cause.minimal), " (shrunk)" if cause.is_shrunk else f" ({name})"
    if test and violation and test.action_times_s and not cause.is_shrunk:
        starts = [(time_s, number) for time_s, number in test.action_starts if time_s <= violation.time_s + 0.001]
        actions = [f"{seconds(time_s)} {test.abstract[number]}" for time_s, number in starts]
    room = None if columns is None else columns - _LABEL
    yield "what", _tail(actions, room, end)
    if violation is not None:
        texts = report.requirements.get(mine)
        unit = unit_of(texts.text, report.units or {}) if texts else ""
        yield "seen", describe_violation(mine, violation, report.units or {}, unit)
    elif test is not None and test.errors:
        yield "seen", test.errors[0]


def _tail(items: Sequence[str], columns: int | None, end: str) -> str:
    """The items with an end, as far as there is room: then without the end, then without the first items."""
    text = "; ".join(items)
    texts = [text + end, text, *(f"... {'; '.join(items[start:])}" for start in range(1, len(items)))]
    fitting = (text for text in texts if columns is None or width(visible(text)) <= columns)
    return next(fitting, texts[-1]) if items else end.strip()


def title_of(number: int, cause: Cause, status: str = "") -> str:
    """`cause 1 (3f2a91bc, new): R29, R21 in 6 tests, first in the state releasing`."""
    return f"cause {number} ({cause.id}{f', {status}' if status else ''}): {summary_of(cause)}"


def summary_of(cause: Cause) -> str:
    """`R29, R21 in 6 tests, first in the state releasing`."""
    listed = list_names(cause.requirements, _MAX_REQUIREMENTS)
    where = f", first in the state {cause.state}" if cause.state else ""
    many = plural(len(cause.tests), "test")
    if (share := cause.probability) is not None:
        percent = 100 * share.failing / share.runs
        many = f"{share.failing:,} of {share.runs:,} runs, {percent:.2f} % ({share.low:.2f} to {share.high:.2f})"
    return f"{listed} in {many}{where}{' (known)' if cause.is_known else ''}"


def replay_of(cause: Cause, options: Sequence[str]) -> str:
    """The command that runs its shortest test again; empty if this has no file."""
    return replay_command(cause.replay, options) if cause.replay else ""


class DiagnosisView(View):
    """Causes of failures."""

    name = "diagnosis"
    scripts = ("code_panel", "passing_neighbour")

    def causes(self, report: Report, columns: int | None) -> FailureCauses | None:
        """The number of causes, then each of them."""
        causes = CAUSES.of(report)
        if not causes:
            return None
        nodeids: dict[str, list[str]] = {}
        for test in report.tests:
            nodeids.setdefault(test.id, []).append(test.nodeid)
        status = _status(report)
        blocks = (
            FailureCause(
                label=f"cause {number}",
                title=title_of(number, cause, status.get(cause.id, "")),
                lines=cause_lines(
                    number, cause, report, columns, status.get(cause.id, ""), is_first=number == 1 or columns is None
                ),
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
        """The number of causes, and each of them in a line."""
        causes = CAUSES.of(report)
        if causes:
            yield "hri.causes", len(causes)
        for number, cause in enumerate(causes, 1):
            lines = cause_lines(number, cause, report, None, is_first=True)
            yield f"hri.cause.{number}", "; ".join(line.text.strip() for line in lines)


VIEW = DiagnosisView()


def _neighbour(report: Report, cause: Cause, test: TestResult) -> dict[str, Any] | None:
    """The nearest passing run, on the page of its test; on those of other tests of the cause, where to find it."""
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
    # Without runs to compare with, everything that failing runs executed gets the highest scores.
    alone = (
        "" if any(test.outcome == "passed" for test in report.tests) else "; no test passed: scores compare with none"
    )
    runs = plural(diagnosis.runs, "run")
    return f"causes: by association over all tests, and {runs} of experiments{ended}{alone}"
