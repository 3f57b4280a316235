"""Records of a diagnosis in `report.json`: causes with their locations, deciding changes and experiments.

`diagnose` makes a `Cause` for each cause and a `Diagnosis` with the evidence; they are the report's sections `CAUSES`
and `DIAGNOSIS`, which `view`, `merging` and `triage` read.
"""

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
"""Why experiments ended: no experiment was left, the budget of runs was used up, or Ctrl-C."""

DIAGNOSIS_ENDS: tuple[DiagnosisEnd, ...] = ("done", "runs", "interrupted")
"""The reasons in increasing order of precedence: a merged report has the last one of its parts."""


class SuspiciousPlace(PlainRecord, frozen=True, kw_only=True):
    """A suspicious statement of the code under test.

    Args:
        line: its first line.
        function: the function that contains it.
        likely: whether it is shown as the location of the cause: its score is clearly above all others, and an
            experiment with this statement, or a comparison of failing and passing runs, supports it.
        experiment: how a failing test passed, such as `passes with this decision reversed`; empty if no run showed it.
        score: its suspiciousness, from 0 to 1 (Ochiai's coefficient, weighted by when it was executed; see
            `locations`).
        text: the source line.
    """

    file: str
    line: Count
    function: str
    score: NotNegative
    likely: bool
    experiment: str = ""
    text: str = ""


class ShownEvent(PlainRecord, frozen=True, kw_only=True):
    """An event of a run: its time (s), and what happened."""

    time_s: NotNegative
    text: str


class ExecutedLines(PlainRecord, frozen=True, kw_only=True):
    """The lines of the code under test that a run executed, with times.

    A burst is what one node of the code executes without simulated time passing. Most bursts recur, so each is stored
    once.

    Args:
        files: files of the code; bursts name them by their index.
        bursts: executed lines in order, such as `0:12 13 17 1:5`; the file is named where it changes.
        nodes: for each node of the code, `time burst time burst ...` (s, index of the burst).
        from_s: time of the first burst that was kept (s); 0 if all were.
        until_s: time of the last one (s); None if all were kept.
        note: why lines are missing or unreliable; empty if they are not.
    """

    files: Names = ()
    bursts: Names = ()
    nodes: Names = ()
    from_s: NotNegative = 0.0
    until_s: NotNegative | None = None
    note: str = ""


class Neighbour(PlainRecord, frozen=True, kw_only=True):
    """The nearest passing run of a cause, shown next to the failing run.

    Args:
        timeline: its timeline.
        abstract: its actions, a line each.
        begun: time (s) and number, from 0, of each action that began, in order.
        lines: the lines of the code that it executed; None if it was not traced.
    """

    timeline: Timeline
    abstract: Names = ()
    begun: tuple[tuple[NotNegative, Count], ...] = ()
    lines: ExecutedLines | None = None


class Decision(PlainRecord, frozen=True, kw_only=True):
    """The minimal pair of a cause: a failing test and the nearest passing variation of it.

    Args:
        words: how the variation differs, as words that follow "passes"; if none passes, why.
        kind: what differs: `schedule`, `disturbance`, `order`, `value`, `command` or `action`; empty if none passes.
        test: id of the failing test.
        runs: number of runs of the search.
        failing: some events of the failing run, from shortly before the two runs diverge.
        passing: the same for the passing run.
        differs_at: index of the first event that differs; None if none does.
        concrete: the actions of the passing test, with their parameters.
        neighbour: the passing run; None if it was not rerun for the page.
        untriggered: whether it passes only because the requirement is never triggered, which explains nothing.
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

    Wilson's interval (1927) over runs estimates how often the cause strikes in these tests; only their seeds are
    random.
    """

    runs: Count
    failing: Count
    low: Percent
    high: Percent


class Cause(PlainRecord, frozen=True, kw_only=True):
    """A cause of failures.

    Args:
        id: made from the change, the state and the requirement that fails first: the same in each session.
        requirements: the requirements that fail for this cause, those of most tests first.
        tests: ids of the tests that fail for this cause, the shortest first.
        change: the disturbance without which they pass; empty if there is none.
        state: state of the code under test when the first of the requirements failed.
        minimal: lines of the shortest of these tests, shrunk if possible.
        minimal_of: id of that test; None in reports of older versions, where it is the first of `tests`.
        is_shrunk: whether lines that the test does not need were removed.
        replay: replay file of that test.
        locations: the suspicious statements, the most suspicious first; empty if no code was measured.
        stood: where each node of the code was at the violation, `file:line in function`; empty if not traced.
        schedule: the schedule under which that test fails; None for the usual one.
        deciding_change: what makes the difference between failing and passing, in words; empty without a search.
        minimal_pair: the result of the search for a minimal pair; None without a search.
        confirmed: number of tests that, as an experiment has shown, fail for this cause.
        is_known: whether all of its violations are known.
        probability: its share of a campaign's runs, if the report contains all of them; else None.
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
        """The locations that reports show."""
        return tuple(location for location in self.locations if location.likely)


class Experiment(PlainRecord, frozen=True, kw_only=True):
    """An experiment: what a run has shown about a failure.

    Args:
        nodeid: node id of the test.
        requirement: the requirement that it violated.
        change: the disturbance that was left out; empty if something else was changed.
        is_confirmed: whether the test passes without it.
        other: another requirement. If confirmed, reversing one decision lets both pass; else it was still violated when
            this one passed, and does not follow from it.
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
        runs: number of runs used by experiments.
        budget: number of runs allowed.
        end_reason: why the experiments ended.
        experiments: what the experiments have shown.
        signals: signals of the testbench, with their types: the conditions of known violations are learned from these.
        messages: messages of the testbench: topic -> field -> type.
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
"""The causes: new ones first, then by number of tests."""

DIAGNOSIS: Section[Diagnosis | None] = Section("diagnosis", Diagnosis | None, None)
"""The diagnosis of a session with failing tests."""

LINES: TestSection[ExecutedLines | None] = TestSection("executed_lines", ExecutedLines | None, None)
"""The lines that a failed test executed, if failures are diagnosed."""

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
