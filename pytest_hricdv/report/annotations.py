"""Failures as GitHub's workflow commands: GitHub shows them beside the test in a pull request.

Format: GitHub Actions, "Workflow commands", `::error file=...,line=...,title=...::text`. GitHub shows ten of a kind per
step, so there is one for each requirement, not one for each test.
"""

from collections.abc import Iterator, Mapping

from pytest_hricdv.report.explanation import violation
from pytest_hricdv.report.formatting import natural, plural, visible
from pytest_hricdv.report.rerun import instructions_of
from pytest_hricdv.report.totals import failed_gates
from pytest_hricdv.results.model import Report, TestResult

MOST = 10

Place = tuple[str, int]
"""A file, relative to the repository's root, and a line from 1."""


def commands(report: Report, places: Mapping[str, Place]) -> tuple[str, ...]:
    """One line for each requirement that was violated and each gate that failed, ten at most.

    Args:
        report: of the session.
        places: node id -> file and line of its test function.
    """
    all_commands = [*_violations(report, places), *_errors(report, places), *_gates(report)]
    if len(all_commands) > MOST:
        rest = len(all_commands) - MOST + 1
        all_commands[MOST - 1 :] = [_command("", f"and {plural(rest, 'more failure')}", "see the report", {})]
    return tuple(all_commands)


def _violations(report: Report, places: Mapping[str, Place]) -> Iterator[str]:
    for name in sorted(report.requirements, key=natural):
        failed = [test for test in report.tests if test.outcome == "failed" and _verdict(test, name) == "Failed"]
        if not failed or (name in report.known_violations and not report.strict):
            continue
        worst = min(failed, key=lambda test: (test.requirements[name].margin or 0.0, test.id))
        first = [violation(each, report.units or {}) for each in worst.requirements[name].violations[:1]]
        lines = [report.requirements[name].title, f"worst is {worst.id}", *first, *instructions_of(report, worst)]
        yield _command(worst.nodeid, f"{name} failed in {plural(len(failed), 'test')}", "\n".join(lines), places)


def _errors(report: Report, places: Mapping[str, Place]) -> Iterator[str]:
    errors = [test for test in report.tests if test.outcome == "error"]
    if errors:
        first = errors[0]
        lines = [f"first is {first.id}", *first.failure.strip().splitlines()[:1], *instructions_of(report, first)]
        yield _command(first.nodeid, f"{plural(len(errors), 'test')} in error", "\n".join(lines), places)


def _gates(report: Report) -> Iterator[str]:
    for text in failed_gates(report):
        yield _command("", "gate failed", text, {})


def _verdict(test: TestResult, requirement: str) -> str:
    return test.requirements[requirement].verdict if requirement in test.requirements else ""


def _command(nodeid: str, title: str, text: str, places: Mapping[str, Place]) -> str:
    parameters = {"title": f"hri: {title}"}
    if nodeid in places:
        file, line = places[nodeid]
        parameters = {"file": file, "line": str(line)} | parameters
    properties = ",".join(f"{key}={_property(value)}" for key, value in parameters.items())
    return f"::error {properties}::{_data(text)}"


def _data(text: str) -> str:
    return visible(text, keep="\n").replace("%", "%25").replace("\n", "%0A")


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
