"""Failures of tests: the violated requirement, the state of the code at that time, and the disturbances before it.

`failures_of` returns a `Failure` for each violated requirement of a test. `Subject.of` calls it for all tests of a
report; `grouping` then groups the failures by cause.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass

from pytest_hricdv._base import own_json as json
from pytest_hricdv.execution.outcome import is_declared
from pytest_hricdv.generate.abstract import disturbance_of
from pytest_hricdv.results.model import TestResult

FAULT = "fault"
"""In place of a requirement for a run that has an error instead of a violation."""

_ROUNDED_S = 0.001
"""Resolution of times in a report (s): a disturbance up to this much after the violation counts as earlier."""

_NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e[+-]?\d+)?")


@dataclass(frozen=True)
class Failure:
    """The first violation of a requirement in a test; the first that is not known, if there is one.

    Args:
        nodeid: the test's node id.
        requirement: its id, or `FAULT`.
        part: distinguishes this from other violations of the requirement: the bools and strings in the formula.
        state: the last state that the code under test had published.
        time_s: the time of the violation (s).
        disturbances: those that had begun before, each once, in order.
        is_known: whether the violation is a known one.
        said: the text of the violation without its numbers.
    """

    nodeid: str
    requirement: str
    part: str
    state: str
    time_s: float
    disturbances: tuple[str, ...]
    is_known: bool
    said: str = ""

    @property
    def kind(self) -> tuple[str, str, str]:
        """Requirement, state and text: failures of the same kind may have the same cause."""
        return self.requirement, self.state, self.said


def failures_of(test: TestResult, state: str, known_violations: Container[str]) -> Iterator[Failure]:
    """The failures of a test, in the order of time.

    Args:
        test: the test of a report.
        state: `topic.field` that carries the state of the code under test; may be empty.
        known_violations: requirements with known violations.
    """
    if not test.went_wrong:  # nearly all of thousands: their messages need not be read
        return iter(())
    states = _States(test, state)
    made = [*_violations(test, states, known_violations), *_faults(test, states)]
    return iter(sorted(made, key=lambda failure: (failure.time_s, failure.requirement)))


def _violations(test: TestResult, states: _States, known_violations: Container[str]) -> Iterator[Failure]:
    for name, result in test.requirements.items():
        judged = [
            (is_declared(name, known_violations, outside=violation.outside), violation)
            for violation in result.violations
        ]
        if not judged:
            continue
        is_known, first = min(judged, key=lambda entry: (entry[0], entry[1].time_s))
        plain = ((key, value) for key, value in sorted(first.values.items()) if isinstance(value, bool | str))
        said = _NUMBER.sub("#", first.text)
        part = ", ".join(f"{key} {value}" for key, value in plain) or said
        before = _disturbances(test, first.time_s)
        yield Failure(test.nodeid, name, part, states.at(first.time_s), first.time_s, before, is_known, said)


def _faults(test: TestResult, states: _States) -> Iterator[Failure]:
    end_s = test.timeline.end_s if test.timeline else test.sim_s
    for fault in test.errors:
        part = _NUMBER.sub("#", fault)
        before = _disturbances(test, end_s)
        yield Failure(test.nodeid, FAULT, part, states.at(end_s), end_s, before, is_known=False, said=part)


def _disturbances(test: TestResult, time_s: float) -> tuple[str, ...]:
    # The lines of several actors need not begin in the order of the test.
    begun = [test.abstract[number] for began_s, number in test.action_starts if began_s <= time_s + _ROUNDED_S]
    return tuple(dict.fromkeys(name for line in begun if (name := disturbance_of(line)) is not None))


class _States:
    """The states that the code under test published over a run."""

    def __init__(self, test: TestResult, state: str) -> None:
        topic, _, name = state.partition(".")
        self._times_s: list[float] = []
        self._names: list[str] = []
        for time_s, fields in _messages(test.timeline.messages if test.timeline and topic else (), topic):
            self._times_s.append(time_s)
            self._names.append(str(json.loads(fields).get(name, "")))

    def at(self, time_s: float) -> str:
        """The state at a time (s), empty before the first. A message of the same millisecond counts as later."""
        count = bisect_right(self._times_s, time_s)
        return self._names[count - 1] if count else ""


def _messages(messages: Sequence[str], topic: str) -> Iterator[tuple[float, str]]:
    """Time (s) and fields of the messages of a topic, of a timeline."""
    for message in messages:
        time_s, _, name, fields = message.split("\t", 3)
        if name == topic:
            yield float(time_s), fields
