"""A run as text: what was said, done and violated, in the order of time; for reports that cannot draw a timeline."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping

from pytest_hricdv._base.message import visible
from pytest_hricdv.report.explanation import violation_line
from pytest_hricdv.results.model import TestResult

_SENDER_COLUMNS = 10
"""Chosen: names of nodes are about as long, and longer ones only shift their own line."""


def timeline_text(test: TestResult, units: Mapping[str, str]) -> str:
    """One line an event: time (s), who, what. A line says so where the run was not completed.

    Args:
        test: with its timeline.
        units: signal -> unit, for the values at violations.
    """
    if test.timeline is None:
        return "no timeline: the run was not completed\n"
    events = [*_messages(test), *_actions(test), *_violations(test, units), (test.timeline.end_s, "", test.ended)]
    lines = (
        f"{time_s:9.3f}  {sender:{_SENDER_COLUMNS}}  {event}".rstrip()
        for time_s, sender, event in sorted(events, key=lambda event: event[0])
    )
    return "".join(f"{visible(line)}\n" for line in lines)


def _messages(test: TestResult) -> Iterator[tuple[float, str, str]]:
    for text in test.timeline.messages if test.timeline else ():
        time_s, sender, topic, fields = text.split("\t", 3)
        said = ", ".join(f"{name} {value}" for name, value in json.loads(fields).items())
        yield float(time_s), sender, f"{topic} {said}".rstrip()


def _actions(test: TestResult) -> Iterator[tuple[float, str, str]]:
    for number, (time_s, line) in enumerate(zip(test.acted_s or (), test.abstract, strict=False), start=1):
        yield time_s, f"action {number}", line


def _violations(test: TestResult, units: Mapping[str, str]) -> Iterator[tuple[float, str, str]]:
    for name, result in test.requirements.items():
        for violation in result.violations:
            yield violation.time_s, name, f"FAILED {violation_line(violation, units)}"
