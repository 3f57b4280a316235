"""What `--hri-schedules` and `--hri-budgets` do after the last test: search schedules, measure time budgets.

`SchedulesFeature.after_tests` calls `search_schedules` and `measure_session_budgets`, whose results go into the report.
Both run tests in a `ScheduleWorker`. `RaceHunt` draws schedules from a `ScheduleSearch`, and shortens each schedule
under which a test fails by a `RaceExamination`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field

from msgspec.structs import replace

from pytest_hricdv._base.schedule_record import FailureKind
from pytest_hricdv.execution.hri_case import HriCase
from pytest_hricdv.execution.outcome import AS_DECLARED
from pytest_hricdv.extra.schedules.budgets import PRECISION_S, measure_budgets, slow_down
from pytest_hricdv.extra.schedules.points import points_of
from pytest_hricdv.extra.schedules.races import RaceExamination, words
from pytest_hricdv.extra.schedules.records import OTHERWISE, BudgetRecord, RaceRecord, ScheduleResult, ScheduleSearchEnd
from pytest_hricdv.extra.schedules.schedule_run import RunTest, ScheduleRun, ScheduleWorker
from pytest_hricdv.extra.schedules.search import ScheduleCandidate, ScheduleSearch
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.generate.schedule import WRITES, schedule_to_data
from pytest_hricdv.report.formatting import plural
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.results.replay import ReplayOrigin
from pytest_hricdv.session.feature import DecidingRun, FeatureSession
from pytest_hricdv.session.replaying import name_test

SLOWEST_S = 0.05
"""Longest hold of a node (s) without `Timing(slowest_s=...)` in the testbench: a busy machine may take as long."""

RUNS_OF_A_TEST = 4
"""Number of runs of the budget per test: a budget of N runs is spent on N / 4 tests."""

MAX_OPEN = 200
"""Maximum number of pairs in the report that came in one order only."""


def search_schedules(
    session: FeatureSession, results: Sequence[TestResult], runs: int
) -> tuple[ScheduleResult, list[str]]:
    """Run tests that passed with other schedules.

    Returns:
        What a report says of it, and the problems that fail the session.
    """
    session.say(f"hricdv: running tests with {plural(runs, 'schedule')} ...")
    with closing(ScheduleWorker(session.rerunner)) as worker:
        hunt = RaceHunt(session, worker.run, runs)
        result = hunt.hunt(results)
    session.deciding_runs += hunt.passing.values()
    return result, [_problem(race) for race in result.races if race.is_counted]


def measure_session_budgets(session: FeatureSession, results: Sequence[TestResult], tests: int) -> list[BudgetRecord]:
    """How slow each function and loop of the code may be, over this number of passed tests."""
    session.say(f"hricdv: measuring time budgets with {plural(tests, 'test')} ...")
    starts = points_of(session.rerunner.settings.testbench.code)[0].starts
    made: list[BudgetRecord] = []
    with closing(ScheduleWorker(session.rerunner)) as worker:
        candidates, left_out = _candidates(session, worker.run, results, tests)
        if left_out:
            session.warnings.append(f"time budgets: {plural(left_out, 'test')} left out: {OTHERWISE}")
        try:
            made.extend(measure_budgets(worker.run, candidates, starts))
        except KeyboardInterrupt:
            session.interrupted = True
    by_test = {candidate.test.id: candidate for candidate in candidates}
    kept = [_keep_broken(session, by_test[budget.test], budget) if budget.test else budget for budget in made]
    return sorted(kept, key=lambda budget: (budget.budget_s, budget.place))


def _keep_broken(session: FeatureSession, candidate: ScheduleCandidate, budget: BudgetRecord) -> BudgetRecord:
    """The budget with a replay file: of its test, a millisecond slower."""
    places = [budget.place, *budget.other.split()[:1]]
    slower = slow_down(candidate.test, places, budget.budget_s + PRECISION_S)
    return replace(budget, replay=_keep(session, candidate, slower, budget.requirement, 1, "late")[1])


def _candidates(
    session: FeatureSession, run: RunTest, results: Sequence[TestResult], most: int
) -> tuple[list[ScheduleCandidate], int]:
    """At most `most` tests that pass, known violations aside, evenly from the shortest to the longest.

    Returns:
        These, and how many were left out, as they do not pass in a process of their own.
    """
    chosen: Mapping[str, HriCase] = session.aggregation.chosen
    passed = sorted(
        (result for result in results if result.outcome in AS_DECLARED and result.nodeid in chosen),
        key=lambda result: (len(result.abstract), result.id, result.nodeid),
    )
    count = min(len(passed), most)
    made = []
    for result in (passed[place * len(passed) // count] for place in range(count)):
        case = chosen[result.nodeid]
        usual = run(case.concrete)
        if usual is not None and not usual.fails - {*session.options.known_violations}:
            made.append(ScheduleCandidate(result.nodeid, case.concrete, case.ranges, usual))
    return made, count - len(made)


@dataclass
class RaceHunt:
    """Runs tests with schedules, and examines those that fail.

    Args:
        budget: the budget of runs with schedules.
    """

    session: FeatureSession
    run: RunTest
    budget: int
    races: list[tuple[frozenset[str], RaceRecord]] = field(default_factory=list)
    """With the places that each involves."""
    lost: int = 0
    _runs: int = 0
    passing: dict[tuple[str, ...], DecidingRun] = field(default_factory=dict)
    """By the places where nodes were held up, the first run that passes: it fails where a bug in the code lets others
    come in between."""

    def __post_init__(self) -> None:
        declared_s = self.session.rerunner.settings.testbench.timing.slowest_s
        self._is_declared = declared_s is not None
        self._search = ScheduleSearch(declared_s or SLOWEST_S, self.session.options.seed)

    def hunt(self, results: Sequence[TestResult]) -> ScheduleResult:
        """Search until the budget is spent."""
        search = self._search
        candidates: list[ScheduleCandidate] = []
        ended: ScheduleSearchEnd = "done"
        left_out = 0
        try:
            candidates, left_out = _candidates(self.session, self.run, results, max(1, self.budget // RUNS_OF_A_TEST))
            for candidate in candidates:
                search.note(candidate.usual)
            ended = self._run_all(candidates)
        except KeyboardInterrupt:
            ended = "interrupted"
        return ScheduleResult(
            runs=self._runs,
            tests=len(candidates),
            left_out=left_out,
            lost=self.lost,
            slowest_s=search.slowest_s,
            races=tuple(race for _, race in self.races),
            pairs=len({frozenset(pair) for pair in search.seen}),
            both=len({frozenset(pair) for pair in search.seen if (pair[1], pair[0]) in search.seen}),
            open=tuple(f"{first} before {second}" for first, second in search.open_pairs()[:MAX_OPEN]),
            end_reason=ended,
        )

    def _run_all(self, candidates: Sequence[ScheduleCandidate]) -> ScheduleSearchEnd:
        for candidate, test in self._search.draw(candidates):
            if self._runs >= self.budget:
                return "done"
            self._runs += 1
            ran = self.run(test)
            if ran is None:
                self.lost += 1
                continue
            self._search.note(ran, candidate, test)
            # What a run violates that has a fault, as a deadlock, follows from that.
            new = sorted(ran.fails - candidate.usual.fails)
            if not new and ran.held:
                self._note_passing(candidate, test, ran)
            for requirement in new[:1] if "" in new else new:
                if not self._is_known(requirement, ran.involves):
                    self.keep(candidate, requirement, test, ran)
        return "nothing to order"

    def _note_passing(self, candidate: ScheduleCandidate, test: ConcreteTest, ran: ScheduleRun) -> None:
        places = tuple(sorted({decision.place for decision in test.schedule}))
        if places not in self.passing:
            others = {conflict.second for conflict in candidate.usual.conflicts if conflict.first in places}
            about = frozenset(place.rstrip(WRITES) for place in {*places, *others} if ":" in place)
            self.passing[places] = DecidingRun(
                candidate.test.id, name_test(test, "schedule"), about, ran.record, ran.ended, ran.outcomes
            )

    def _is_known(self, requirement: str, places: frozenset[str]) -> bool:
        """Whether a race with this requirement at one of these places, or at none, was found already."""
        return any(
            race.requirement == requirement and (before & places or before == places) for before, race in self.races
        )

    def keep(self, candidate: ScheduleCandidate, requirement: str, test: ConcreteTest, ran: ScheduleRun) -> None:
        """Shrink a test that fails under its schedule, and keep it unless it is known."""
        is_moved = test.actions != candidate.test.actions
        examination = RaceExamination(self.run, lambda run: requirement in run.fails, is_moved)
        race = examination.examine(test, ran)
        kind: FailureKind = "deadlock" if not requirement and race.ran.is_deadlock else race.kind
        made, replay = _keep(self.session, candidate, race.test, requirement, race.runs, kind)
        if self._is_known(requirement, race.ran.involves):
            return
        tolerated = requirement in self.session.options.known_violations and not self.session.options.strict
        record = RaceRecord(
            requirement=requirement,
            fault=race.ran.faults[0] if not requirement and race.ran.faults else "",
            test=candidate.test.id,
            failure_kind=kind,
            schedule=schedule_to_data(race.test.schedule),
            words=words(candidate, race),
            least_s=round(race.least_s, 6),
            is_counted=not tolerated and (kind != "late" or self._is_declared),
            found_after=self._runs,
            id=made,
            replay=replay,
        )
        self.races.append((race.ran.involves, record))


def _keep(
    session: FeatureSession,
    candidate: ScheduleCandidate,
    test: ConcreteTest,
    requirement: str,
    runs: int,
    kind: FailureKind,
) -> tuple[str | None, str | None]:
    """Id and replay file of the candidate's test with a schedule."""
    with session.signals.let_through():
        result = session.rerunner.run(name_test(test, "schedule"))
    if result is None:
        return None, None
    origin = ReplayOrigin("schedule", candidate.test.id, requirement or "fault", runs, kind)
    case = session.aggregation.chosen[candidate.nodeid]
    kept, replay = session.rerunner.keep(case, result, candidate.nodeid, origin)
    return kept.abstract.id, replay


def _problem(race: RaceRecord) -> str:
    what = f"{race.requirement} is violated" if race.requirement else race.fault
    return f"{what}, by {race.test} under another schedule ({race.failure_kind}): {race.words}"
