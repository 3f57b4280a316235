"""Failures as GitHub annotations, one for each cause (`annotation_commands`); the plugin `Exporter` prints them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

from pytest_hricdv._base.message import MAX_LINE, cut, visible
from pytest_hricdv.report import totals
from pytest_hricdv.report.explanation import instructions_of
from pytest_hricdv.report.failing_tests import FailingTests
from pytest_hricdv.report.formatting import by_requirement, plural, split_first
from pytest_hricdv.report.violations import margin_unit, violation_line
from pytest_hricdv.results.model import Report, TestResult

MAX_ANNOTATIONS = 10
"""Most annotations of a session: GitHub shows ten of a kind per step of a job."""

Place = tuple[str, int]
"""A file, relative to the repository's root, and a line from 1."""


def annotation_commands(
    report: Report, places: Mapping[str, Place], in_repository: Callable[[str], str] = str
) -> tuple[str, ...]:
    """Failures as GitHub's workflow commands: GitHub shows them next to code and tests in a pull request.

    Format: GitHub Actions, "Workflow commands", `::error file=...,line=...,title=...::text`.

    Args:
        places: node id -> file and line of its test function.
        in_repository: the name of a file of the code under test, as GitHub expects it.

    Returns:
        A line for each cause, at its place in the code; of tests without one, for each requirement that was violated,
        for tests in error or with a fault; and for each gate that failed. At most `MAX_ANNOTATIONS`.
    """
    causes = FailingTests.of(report)
    explained = causes.labels().keys()
    left = [test for test in report.tests if test.nodeid not in explained]
    commands = [
        *_cause_annotations(causes, places, in_repository),
        *_violation_annotations(report, left, places),
        *_test_annotations(report, left, places),
        *_gate_annotations(report),
    ]
    if len(commands) > MAX_ANNOTATIONS:
        rest = len(commands) - MAX_ANNOTATIONS + 1
        commands[MAX_ANNOTATIONS - 1 :] = [_annotation(None, f"and {plural(rest, 'more failure')}", "see the report")]
    return tuple(commands)


def _cause_annotations(
    failing: FailingTests, places: Mapping[str, Place], in_repository: Callable[[str], str]
) -> Iterator[str]:
    for cause, nodeids in failing.groups:
        if cause is None or cause.is_known or not nodeids:
            continue
        host = places.get(nodeids[0])
        place = host if cause.place is None else (in_repository(cause.place[0]), cause.place[1])
        lines = [line.text.strip() for line in cause.lines[1:]]
        if len(nodeids) > 1:
            first, more = split_first(nodeids, 20)
            lines += ["", *(line.text.strip() for line in failing.rows(first))]
            lines += [f"and {more} more"] if more else []
        yield _annotation(place, cause.title, "\n".join(lines))


def _violation_annotations(report: Report, tests: Sequence[TestResult], places: Mapping[str, Place]) -> Iterator[str]:
    for name in sorted(report.requirements, key=by_requirement):
        failed = [test for test in tests if test.fails and test.violates(name)]
        failed = [test for test in failed if not totals.is_tolerated(report, name, test)]
        if not failed:
            continue
        worst = min(failed, key=lambda test: (test.requirements[name].margin or 0.0, test.id))
        violations = sorted(worst.requirements[name].violations, key=lambda violation: not violation.outside)
        unit = margin_unit(report, name)
        first = [violation_line(violation, report.units or {}, unit) for violation in violations[:1]]
        lines = [report.requirements[name].title, f"worst is {worst.id}", *first, *instructions_of(report, worst)]
        title = f"{name} failed in {plural(len(failed), 'test')}"
        yield _annotation(places.get(worst.nodeid), title, "\n".join(lines))


def _test_annotations(report: Report, tests: Sequence[TestResult], places: Mapping[str, Place]) -> Iterator[str]:
    errors = [(test, test.failure.strip().splitlines()[:1]) for test in tests if test.outcome == "error"]
    faults = [(test, test.errors) for test in tests if test.errors]
    for same, ended in ((errors, "in error"), (faults, "with a fault")):
        if same:
            first, texts = same[0]
            lines = [f"first is {first.id}", *texts, *instructions_of(report, first)]
            yield _annotation(places.get(first.nodeid), f"{plural(len(same), 'test')} {ended}", "\n".join(lines))


def _gate_annotations(report: Report) -> Iterator[str]:
    for text in totals.list_gate_failures(report):
        yield _annotation(None, "gate failed", text)


def _annotation(place: Place | None, title: str, text: str) -> str:
    parameters = {"title": f"hri: {title}"}
    if place is not None:
        parameters = {"file": place[0], "line": str(place[1])} | parameters
    properties = ",".join(f"{key}={_annotation_property(value)}" for key, value in parameters.items())
    return f"::error {properties}::{_annotation_text(text)}"


def _annotation_text(text: str) -> str:
    return visible(cut(text, 2 * MAX_LINE), keep="\n").replace("%", "%25").replace("\n", "%0A")


def _annotation_property(text: str) -> str:
    return _annotation_text(text).replace(":", "%3A").replace(",", "%2C")
