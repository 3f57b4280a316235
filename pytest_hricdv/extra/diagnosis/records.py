"""Records of the causes of failures in a report."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from msgspec import Struct
from msgspec.structs import replace

from pytest_hricdv._base.record import Count, Names, NotNegative, Percent, PlainRecord, ReplayName, TestId
from pytest_hricdv._base.schedule_record import ScheduleData
from pytest_hricdv.results.behaviour import Timeline
from pytest_hricdv.results.section import FileNames, Section, TestSection

DiagnosisEnd = Literal["done", "runs", "interrupted"]
"""Why experiments ended: none was left, or the budget of runs was used up, or Ctrl-C."""

DIAGNOSIS_ENDS: tuple[DiagnosisEnd, ...] = ("done", "runs", "interrupted")
"""In increasing order of precedence, for merged reports."""


class SuspiciousPlace(PlainRecord, frozen=True, kw_only=True):
    """A statement of the code under test.

    Args:
        file: as the report names it.
        line: its first line.
        function: it is in.
        likely: whether it rests on evidence: an experiment with this statement, or, where none has shown another one, a
            comparison of failing and passing runs with a high enough score. Only such a statement is shown as the
            location of the cause.
        experiment: how a failing test passed, as `passes with this decision reversed`; empty if no run has shown it.
        score: its suspiciousness, from 0 to 1 (Ochiai's coefficient, weighted by when it was executed; see `location`).
        text: the line.
    """

    file: str
    line: Count
    function: str
    score: NotNegative
    likely: bool
    experiment: str = ""
    text: str = ""


class ShownEvent(PlainRecord, frozen=True, kw_only=True):
    """An event of a run: when (s), and what happened."""

    time_s: NotNegative
    text: str


class ExecutedLines(PlainRecord, frozen=True, kw_only=True):
    """The lines of the code under test that a run executed, with times.

    A burst is what one node of the code executes without simulated time passing. Most bursts come again and again, so
    each is written once.

    Args:
        files: of the code, by whose numbers from 0 bursts name them.
        bursts: lines in the order in which they were executed, as `0:12 13 17 1:5`: a file is named where it changes.
        nodes: of each node of the code, `time burst time burst ...` (s, number of the burst from 0).
        from_s: when what was kept begins (s); 0 if it is all.
        until_s: when it ends; None if it is all.
        note: what is wrong with it, or why there is none; empty for nothing.
    """

    files: Names = ()
    bursts: Names = ()
    nodes: Names = ()
    from_s: NotNegative = 0.0
    until_s: NotNegative | None = None
    note: str = ""


class Neighbour(PlainRecord, frozen=True, kw_only=True):
    """The run of the nearest passing neighbour, to be shown next to the failing run.

    Args:
        timeline: of it.
        abstract: its actions, a line each.
        begun: when actions began (s), and which, by their numbers from 0, in the order of time.
        lines: of the code that it executed.
    """

    timeline: Timeline
    abstract: Names = ()
    begun: tuple[tuple[NotNegative, Count], ...] = ()
    lines: ExecutedLines | None = None


class Decision(PlainRecord, frozen=True, kw_only=True):
    """The minimal pair of a cause: a failing test, and its nearest neighbour that passes.

    Args:
        words: what the neighbour has otherwise, as they follow "passes"; where no neighbour passes, why that is.
        kind: in what it differs: `disturbance`, `order`, `value`, `command` or `action`; empty if none passes.
        test: id of the test that fails.
        runs: how many runs it took.
        failing: some events of the failing run, from before both part.
        passing: the same of the neighbour.
        differs_at: which of these events is the first that differs, from 0; None if none does.
        concrete: the actions of the neighbour, with their parameters.
        neighbour: its run; None if it was not run once more to be shown.
        untriggered: it passes only because the requirement is never triggered then, which explains nothing.
    """

    words: str
    untriggered: bool = False
    kind: Literal["", "schedule", "disturbance", "order", "value", "command", "action"] = ""
    test: TestId
    runs: Count
    failing: tuple[ShownEvent, ...] = ()
    passing: tuple[ShownEvent, ...] = ()
    differs_at: Count | None = None
    concrete: Names = ()
    neighbour: Neighbour | None = None


class Probability(PlainRecord, frozen=True, kw_only=True):
    """The share of a campaign's runs that fail for a cause, with its 95 % confidence interval (per cent).

    Wilson's interval (1927), over runs: it estimates how often the cause strikes in these tests, whose seeds alone are
    random.
    """

    runs: Count
    failing: Count
    low: Percent
    high: Percent


class Cause(PlainRecord, frozen=True, kw_only=True):
    """A cause of failures.

    Args:
        id: from the change, the state and the requirement that fails first: the same in each session.
        requirements: that fail for it, those of most tests first.
        tests: ids of the tests, the shortest first.
        change: the disturbance without which they pass; empty if there is none.
        state: of the code under test when the first of the requirements failed.
        minimal: lines of the shortest of these tests, or what was left of it.
        minimal_of: id of this test; None in reports of older versions: the first of `tests`.
        is_shrunk: what the test does not need was taken away.
        replay: of this test.
        locations: the most suspicious statements first; empty if no code was measured.
        stood: where each node of the code was at the violation, `file:line in function`; of a traced run only.
        schedule: under which this test fails; None for the usual one.
        deciding_change: what makes the difference between failing and passing, in words; empty if nobody tried.
        minimal_pair: the result of the search for a minimal pair; None without a search.
        confirmed: number of tests that, as an experiment has shown, fail for it.
        is_known: all of its violations are known ones.
        probability: in a campaign all runs of which are in the report; else None.
    """

    id: str
    requirements: Names
    tests: tuple[TestId, ...]
    change: str = ""
    state: str = ""
    minimal: Names = ()
    minimal_of: TestId | None = None
    is_shrunk: bool = False
    replay: ReplayName | None = None
    locations: tuple[SuspiciousPlace, ...] = ()
    stood: Names = ()
    schedule: ScheduleData | None = None
    deciding_change: str = ""
    minimal_pair: Decision | None = None
    confirmed: Count = 0
    is_known: bool = False
    probability: Probability | None = None

    @property
    def likely_locations(self) -> tuple[SuspiciousPlace, ...]:
        """The locations that are shown."""
        return tuple(location for location in self.locations if location.likely)


class Experiment(PlainRecord, frozen=True, kw_only=True):
    """An experiment: what a run has shown about a failure.

    Args:
        nodeid: of the test.
        requirement: that it violated.
        change: the disturbance that was left out; empty if something else was done otherwise.
        is_confirmed: it passes without; otherwise it fails all the same.
        other: another requirement. Confirmed, one reversed decision lets both pass; else it was still violated
            when this one passed, and does not follow from it.
    """

    nodeid: str
    requirement: str
    change: str
    is_confirmed: bool
    other: str = ""


KindName = Literal["bool", "float", "str"]


class Diagnosis(PlainRecord, frozen=True, kw_only=True):
    """The evidence that the causes rest on.

    Args:
        runs: of experiments.
        budget: number of runs allowed.
        end_reason: why they ended.
        experiments: what they have shown.
        signals: of the testbench, with their types: in these conditions are learned.
        messages: of the testbench: topic -> field -> type.
    """

    runs: Count
    budget: Count
    end_reason: DiagnosisEnd
    experiments: tuple[Experiment, ...] = ()
    signals: Mapping[str, KindName] = {}
    messages: Mapping[str, Mapping[str, KindName]] = {}


def _rename(causes: tuple[Cause, ...], names: FileNames) -> tuple[Cause, ...]:
    return tuple(replace(cause, replay=names.replay(cause.replay)) for cause in causes)


CAUSES: Section[tuple[Cause, ...]] = Section("causes", tuple[Cause, ...], (), rename=_rename)
"""The causes, new ones first, then those of most tests."""

DIAGNOSIS: Section[Diagnosis | None] = Section("diagnosis", Diagnosis | None, None)
"""The diagnosis of a session with failing tests."""

LINES: TestSection[ExecutedLines | None] = TestSection("executed_lines", ExecutedLines | None, None)
"""The lines that a failed test executed, where failures are diagnosed."""

SECTIONS = (CAUSES, DIAGNOSIS)
TEST_SECTIONS = (LINES,)


def failure_causes(report: Struct, suite: str) -> dict[str, str] | None:
    """The causes of new violations, by id; see `pytest_hricdv.results.section.failure_causes`."""
    tests = report.tests  # type: ignore[attr-defined]
    if DIAGNOSIS.of(report) is None and any(test.fails for test in tests):
        return None
    ids = {test.id for test in tests if suite in ("", test.suite)}
    return {
        cause.id: f"{', '.join(cause.requirements)}{f', first in the state {cause.state}' if cause.state else ''}"
        for cause in CAUSES.of(report)
        if not cause.is_known and not ids.isdisjoint(cause.tests)
    }
