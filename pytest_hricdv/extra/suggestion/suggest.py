"""`suggest`: what `hricdv suggest` does after the last test of its session: record runs, and mine them.

`SuggestionFeature` calls it with the report; a `Suggester` does the work.
"""

from __future__ import annotations

import importlib.util
import os
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import cast

from pytest_hricdv.execution.faulty_import import SeededFault
from pytest_hricdv.execution.hri_case import HriCase
from pytest_hricdv.execution.outcome import AS_DECLARED
from pytest_hricdv.execution.run_monitors import formulas
from pytest_hricdv.extra.suggestion.events import Runs
from pytest_hricdv.extra.suggestion.mining import CandidatePool, CandidateScore, list_open_tests, mine
from pytest_hricdv.extra.suggestion.options import SuggestionOptions
from pytest_hricdv.extra.suggestion.recordings import RecordingError, Recordings, vary_tests
from pytest_hricdv.extra.suggestion.records import SUGGESTIONS, Suggestion, SuggestionEnd, SuggestionResult
from pytest_hricdv.extra.suggestion.stored_run import StoredRun
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.generate.rng import make_rng, shuffle
from pytest_hricdv.registry import offers
from pytest_hricdv.report.formatting import plural
from pytest_hricdv.results.model import Report, TestResult
from pytest_hricdv.session.feature import FeatureSession

FOLDER = "suggestions"
"""The folder of stored runs, in the report's folder."""

MAX_TESTS = 60
"""Maximum number of tests whose runs are mined; they are drawn with the seed."""

MIN_TESTS = 3
"""Minimum number of tests whose runs are mined: fewer are not evidence."""

MAX_ROUNDS = 5
"""Maximum number of rounds; in each, suggestions that fail if runs continue are replaced by the next candidates."""

TESTS_OF_FAULT = 4
"""Number of tests that each bug is tried on. The first executes the bug's statement and little else; the others execute
as much as possible."""


Trials = tuple[Mapping[SeededFault, Sequence[tuple[ConcreteTest, str]]], int]
"""Bugs with the tests to try them on, each with the hash of its record; and how many bugs no test reaches."""


def suggest(session: FeatureSession, report: Report, settings: SuggestionOptions) -> Report:
    """The report with the suggestions; if none can be made, the session's problems say why."""
    tests = sorted(
        (result for result in session.results if result.outcome in AS_DECLARED),
        key=lambda result: (result.suite, result.id, result.nodeid),
    )
    if len(tests) < MIN_TESTS:
        session.problems.append(
            f"--hri-suggest: expected at least {MIN_TESTS} tests that pass, got {plural(len(tests), 'test')}: run a "
            "larger suite, as --hri-suite=rl, or fix what fails"
        )
        return report
    drawn = shuffle(make_rng("suggest", session.options.seed), tests)[:MAX_TESTS]
    try:
        return SUGGESTIONS.put(report, Suggester(session, settings, drawn).suggest())
    except RecordingError as error:
        session.problems.append(f"--hri-suggest: {error}")
    except KeyboardInterrupt:
        session.interrupted = True
    return report


@dataclass
class Suggester:
    """Suggests requirements for a session.

    Args:
        tests: the results to mine, in the order in which they were drawn.
    """

    session: FeatureSession
    settings: SuggestionOptions
    tests: Sequence[TestResult]
    _notes: list[str] = field(default_factory=list, init=False)

    def suggest(self) -> SuggestionResult:
        """Record runs, mine them, and rank what holds in all of them.

        Raises:
            RecordingError: no runs can be recorded.
            KeyboardInterrupt: the user pressed Ctrl-C; the next session resumes with what is stored.
        """
        began_s, settings, session = time.perf_counter(), self.settings, self.session
        cases = [session.aggregation.chosen[test.nodeid] for test in self.tests]
        recordings = self._recordings()
        own = recordings.of_tests([case.concrete for case in cases], "tests")
        varied = recordings.of_tests(vary_tests(cases, settings.further), "tests with other parameters")
        of_faults, unreached, ended = self._runs_of_faults(recordings)
        faulty = [*of_faults.values()]
        session.say(f"hricdv: mining {len(own) + len(varied)} runs ...")
        pool = mine(self._runs([*own, *varied]), faulty, self._requirements())
        pool = self._continue_runs(pool, recordings, own, cases)
        ranked = pool.rank()
        shown = ranked[: settings.most]
        return SuggestionResult(
            suggestions=tuple(self._describe(shown, pool)),
            more=len(ranked) - len(shown),
            runs=len(own),
            validation_runs=len(varied),
            candidates=pool.candidates,
            refuted=pool.refutation_count,
            faults=len(of_faults),
            noticed=pool.noticed.bit_count(),
            unreached=unreached,
            ignores_existing=settings.anew,
            seed=session.options.seed,
            wall_s=round(time.perf_counter() - began_s, 3),
            end_reason=ended,
            notes=tuple(self._notes),
        )

    def _recordings(self) -> Recordings:
        session = self.session
        aggregation = session.aggregation
        processes = aggregation.workers if aggregation.is_distributed else os.cpu_count() or 1
        slowest_s = max((test.wall_s or 0.0 for test in self.tests), default=0.0)
        folder = session.options.report / FOLDER
        return Recordings(session.context, folder, processes, slowest_s, session.say, session.signals.let_through)

    def _runs(self, runs: Sequence[StoredRun]) -> Runs:
        testbench = self.session.context.collection.testbench
        return Runs(runs, testbench.vocabulary(), frozenset(testbench.model.who_acts), testbench.state.name)

    def _requirements(self) -> list[str]:
        """Ids of those that candidates compete with."""
        requirements = () if self.settings.anew else formulas(self.session.context.requirements)
        return [requirement.id for requirement in requirements]

    def _runs_of_faults(self, recordings: Recordings) -> tuple[dict[SeededFault, list[StoredRun]], int, SuggestionEnd]:
        """Seeded bug -> its runs that differ, if any do; number of bugs that no test reaches; why the search ended."""
        session, settings = self.session, self.settings
        measured = [test for test in self.tests if test.code is not None]
        seed = self._seed(measured) if settings.faults else None
        if seed is None:
            return {}, 0, "done"
        trials, unreached = seed(session.context, measured, session.aggregation.chosen, settings.faults, TESTS_OF_FAULT)
        runs = recordings.of_faults(trials, settings.seconds)
        left = len(trials) - len(runs)
        if left:
            self._notes.append(f"{left} of {plural(len(trials), 'seeded bug')} not tried: time ran out")
        return {fault: changed for fault, changed in runs.items() if changed}, unreached, "seconds" if left else "done"

    def _seed(self, measured: Sequence[TestResult]) -> Callable[..., Trials] | None:
        """The function that seeds bugs; None, with a note, if there is none."""
        makers = offers("feature", "seed_faults")
        if makers and importlib.util.find_spec("mutmut") is not None and measured:
            return cast("Callable[..., Trials]", makers[0])
        reason = "no test was measured, so it is unknown which tests reach them"
        if not makers:
            reason = "the feature mutation is not installed"
        elif importlib.util.find_spec("mutmut") is None:
            reason = "they need mutmut: pip install pytest-hricdv[mutation]"
        self._notes.append(f"not ranked by seeded bugs: {reason}")
        return None

    def _continue_runs(
        self, pool: CandidatePool, recordings: Recordings, own: Sequence[StoredRun], cases: Sequence[HriCase]
    ) -> CandidatePool:
        """Drop candidates that fail if a run continues until they are decided, as it does once they are accepted."""
        tests = {case.concrete.id: case.concrete for case in cases}
        for _ in range(MAX_ROUNDS):
            shown = pool.rank()[: self.settings.most]
            texts = tuple(score.candidate.formula for score in shown)
            undecided = [tests[name] for name in list_open_tests(shown, own)]
            runs = recordings.of_tests(undecided, "tests that continue until suggestions are decided", texts)
            refuted = {name for run in runs for name in run.failed}.intersection(texts)
            if not refuted:
                break
            pool = pool.drop(refuted)
        return pool

    def _describe(self, shown: Sequence[CandidateScore], pool: CandidatePool) -> list[Suggestion]:
        names, noticed, suggestions = {*self.session.context.texts}, pool.noticed, []
        number = 0
        for score in shown:
            number += 1
            while f"S{number}" in names:
                number += 1
            tally, candidate = score.tally, score.candidate
            suggestions.append(
                Suggestion(
                    id=f"S{number}",
                    title=candidate.title,
                    formula=candidate.formula,
                    form=candidate.form,
                    triggers=tally.triggers,
                    decisive=tally.decisive,
                    margin=None if tally.least is None else round(tally.least, 6),
                    observed=candidate.observed,
                    faults=score.faults.bit_count(),
                    new=score.new.bit_count(),
                    added=(score.faults & ~noticed).bit_count(),
                )
            )
            noticed |= score.faults
        return suggestions
