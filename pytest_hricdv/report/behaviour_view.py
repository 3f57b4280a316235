"""How a report shows changes of behaviour since the baseline, which `results.behaviour_diff` found.

`brief_summary` and `terminal` print the `lines`, `markdown` has the `sentence`, and the page (`html`) the `examples`.
"""

from collections.abc import Iterator
from typing import Any

from pytest_hricdv._base import own_json as json
from pytest_hricdv._base.message import visible
from pytest_hricdv.report.formatting import Line, Style, listing, plural, split_first, width, wrap
from pytest_hricdv.results.behaviour import Behaviour, BehaviourChanges, ChangeKind
from pytest_hricdv.results.behaviour_diff import headline
from pytest_hricdv.results.model import Report, TestResult


def lines(report: Report, columns: int) -> Iterator[Line]:
    """How the tests behave, compared with the baseline, in lines of limited width; empty without a baseline."""
    changes = report.changes
    if changes is None or not report.reported:
        return
    yield Line(headline(changes), "warn" if changes.changed or not changes.compared else "ok")
    room = max((len(str(kind.tests)) for kind in changes.kinds), default=1) + 4
    shown, more = split_first(changes.kinds, 8)
    for kind in shown:
        yield from _wrap_lines(f"{kind.tests:>{room - 2}}  ", kind.kind, columns, "warn")
        yield from _wrap_lines(" " * room, _example(report, changes, kind), columns)
    if more:
        yield Line(f"  ... and {plural(more, 'more kind')}: see the report", "dim")
    for names, where in ((changes.new, "not in the baseline"), (changes.removed, "only in the baseline")):
        if names:
            start = f"  {plural(len(names), 'test')} {where}: "
            yield Line(visible(start + listing(names, columns - width(start))), "dim")
    for note in changes.notes:
        yield from _wrap_lines("  ", note, columns, "warn")


def sentence(report: Report) -> str:
    """A sentence on the behaviour, with the first difference of the most frequent kind; empty without a baseline."""
    changes = report.changes
    if changes is None or not report.reported:
        return ""
    example = f"; {_example(report, changes, changes.kinds[0])}" if changes.kinds else ""
    return headline(changes) + example


def examples(report: Report) -> list[tuple[ChangeKind, TestResult, str]]:
    """Each kind of change with its example, and the first difference of this."""
    changes = report.changes
    if changes is None:
        return []
    tests = {test.nodeid: test for test in report.tests}
    return [(kind, tests[kind.example], changes.changed[kind.example].text) for kind in changes.kinds]


def index(report: Report) -> list[dict[str, Any]]:
    """Each kind of change, with the places of its tests among the report's tests, as plain data."""
    changes = report.changes
    if changes is None:
        return []
    kinds = [changes.changed[test.nodeid].kind if test.nodeid in changes.changed else None for test in report.tests]
    return [
        {"kind": change.kind, "tests": [number for number, kind in enumerate(kinds) if kind == change.kind]}
        for change in changes.kinds
    ]


def details(report: Report, test: TestResult) -> dict[str, Any] | None:
    """How a test's run differs from that of the baseline, as plain data; None if it does not, or without one."""
    change = report.changes.changed.get(test.nodeid) if report.changes else None
    if change is None:
        return None
    return {
        "against": report.changes.against if report.changes else "",
        "text": change.text,
        "time": change.time_s,
        "topic": change.topic,
        "also": change.also,
        "before": _timeline(change.before),
    }


def _timeline(behaviour: Behaviour) -> dict[str, Any]:
    """The messages of a run in the form of a timeline."""
    lines = ("\t".join([f"{time_s}", *names, json.dumps(fields)]) for time_s, *names, fields in behaviour.messages)
    return {"end_s": behaviour.end_s, "messages": [*lines], "signals": {}, "triggers": {}}


def _example(report: Report, changes: BehaviourChanges, kind: ChangeKind) -> str:
    (test,) = (test.id for test in report.tests if test.nodeid == kind.example)
    return f"first difference in {test}: {changes.changed[kind.example].text}"


def _wrap_lines(start: str, text: str, columns: int, style: Style = "plain") -> Iterator[Line]:
    """Text behind a start, which continues below itself if it is too long."""
    for line in wrap(visible(text).split(" "), columns - width(start)):
        yield Line(start + line, style)
        start = " " * width(start)
