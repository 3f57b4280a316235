"""Suggesting: when all tests have run, requirements are learnt of their runs."""

from __future__ import annotations

import os
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from pytest_hricdv.execution.case import HriCase, formulas
from pytest_hricdv.execution.outcome import AS_DECLARED
from pytest_hricdv.extra.suggestion import faults as seeded
from pytest_hricdv.extra.suggestion.learning import Evidence, Learnt, alike, learnt, unmoved
from pytest_hricdv.extra.suggestion.options import SuggestionOptions
from pytest_hricdv.extra.suggestion.ranking import Rated
from pytest_hricdv.extra.suggestion.recordings import Fault, RecordingError, Recordings, further_tests
from pytest_hricdv.extra.suggestion.records import SUGGESTIONS, Suggestion, SuggestionEnd, SuggestionResult
from pytest_hricdv.extra.suggestion.stored_run import StoredRun
from pytest_hricdv.extra.suggestion.views import Runs, copied
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.generate.rng import make_rng, shuffled
from pytest_hricdv.report.formatting import plural
from pytest_hricdv.results.model import Report, TestResult
from pytest_hricdv.session.feature import FeatureSession

FOLDER = "suggestions"
"""Of stored runs, in the folder of the report."""

MOST_TESTS = 60
"""Suggestions are learnt of so many tests at most, drawn with the seed. Chosen: with more, hardly any bound changes."""

MOST_ROUNDS = 5
"""So often what is refuted is left out, and others take its place (chosen: mostly two are enough)."""

LEAST_TESTS = 3
"""Of fewer runs nothing can be learnt."""


def suggested(session: FeatureSession, report: Report, settings: SuggestionOptions) -> Report:
    """The report with the suggestions; where none can be made, the session's problems say why."""
    tests = sorted(
        (result for result in session.results if result.outcome in AS_DECLARED),
        key=lambda result: (result.suite, result.id, result.nodeid),
    )
    if len(tests) < LEAST_TESTS:
        session.problems.append(
            f"--hri-suggest: expected at least {LEAST_TESTS} tests that pass, to learn of; there "
            f"{'is' if len(tests) == 1 else 'are'} {plural(len(tests), 'test')}: run a larger suite, as "
            "--hri-suite=rl, or mend what fails"
        )
        return report
    drawn = shuffled(make_rng("suggest", session.options.seed), tests)[:MOST_TESTS]
    try:
        return SUGGESTIONS.put(report, Suggesting(session, settings, drawn).result())
    except RecordingError as error:
        session.problems.append(f"--hri-suggest: {error}")
    except KeyboardInterrupt:
        session.interrupted = True
    return report


@dataclass
class Suggesting:
    """Suggests requirements for a session.

    Args:
        session: whose tests have run.
        settings: how.
        tests: the results to learn of, in the order in which they were drawn.
    """

    session: FeatureSession
    settings: SuggestionOptions
    tests: Sequence[TestResult]
    _notes: list[str] = field(default_factory=list, init=False)

    def result(self) -> SuggestionResult:
        """Record runs, learn of them, try to refute what was learnt, and rank it.

        Raises:
            RecordingError: no runs can be recorded.
            KeyboardInterrupt: it was interrupted; the next session goes on with what is stored.
        """
        began_s, settings = time.perf_counter(), self.settings
        cases = [self.session.aggregation.chosen[test.nodeid] for test in self.tests]
        recordings = self._recordings()
        own = recordings.of_tests([case.concrete for case in cases], "tests")
        early = recordings.of_tests(further_tests(cases, settings.further // 2), "further tests")
        of_faults, unreached, ended = self._faults(recordings)
        evidence = self._evidence([*own, *early], of_faults, {run.test: run for run in own})
        self.session.say(f"hricdv: learning of {len(evidence.runs.runs)} runs ...")
        first = learnt(evidence)
        late_tests = self._refuting(first.ranked[: settings.most], cases, settings.further - settings.further // 2)
        late = recordings.of_tests(late_tests, "tests to refute what was learnt")
        kept = self._going_on(first.without(late), recordings, own, cases)
        ranked = kept.ranked
        shown = ranked[: settings.most]
        return SuggestionResult(
            suggestions=tuple(self._described(shown, kept)),
            more=len(ranked) - len(shown),
            runs=len(own),
            further=len(early) + len(late),
            candidates=first.candidates,
            refuted=kept.refuted,
            faults=len(of_faults),
            noticed=evidence.taken.bit_count(),
            unreached=unreached,
            anew=settings.anew,
            seed=self.session.options.seed,
            wall_s=round(time.perf_counter() - began_s, 3),
            ended=ended,
            notes=tuple(self._notes),
        )

    def _recordings(self) -> Recordings:
        session = self.session
        aggregation = session.aggregation
        processes = aggregation.workers if aggregation.is_distributed else os.cpu_count() or 1
        slowest_s = max((test.wall_s or 0.0 for test in self.tests), default=0.0)
        folder = session.options.report / FOLDER
        return Recordings(session.context, folder, processes, slowest_s, session.say, session.signals.let_through)

    def _faults(self, recordings: Recordings) -> tuple[dict[Fault, list[StoredRun]], int, SuggestionEnd]:
        """Fault -> its runs that differ, of those that change any; how many no test reaches; why it ended."""
        session, settings = self.session, self.settings
        measured = [test for test in self.tests if test.code is not None]
        if settings.faults and not seeded.can_be_made():
            self._notes.append("ranked by no seeded faults, which need mutmut: pip install pytest-hricdv[mutation]")
        elif settings.faults and not measured:
            self._notes.append("ranked by no seeded faults: no test was measured, so nobody knows which reach them")
        elif settings.faults:
            trials, unreached = seeded.trials(session.context, measured, session.aggregation.chosen, settings.faults)
            runs = recordings.of_faults(trials, settings.seconds)
            ended: SuggestionEnd = "done" if len(runs) == len(trials) else "seconds"
            if ended == "seconds":
                self._notes.append(
                    f"{len(trials) - len(runs)} of {plural(len(trials), 'fault')} not tried: time was over"
                )
            return {fault: changed for fault, changed in runs.items() if changed}, unreached, ended
        return {}, 0, "done"

    def _evidence(
        self, runs: Sequence[StoredRun], of_faults: Mapping[Fault, list[StoredRun]], own: Mapping[str, StoredRun]
    ) -> Evidence:
        testbench, settings = self.session.context.collection.testbench, self.settings
        every = formulas(self.session.context.requirements)
        faulty, vocabulary = [*of_faults.values()], testbench.vocabulary()
        unrepeated = vocabulary.without_signals(copied(runs, vocabulary))
        runs_of = Runs.of(runs, unrepeated, testbench.model.who_acts, testbench.state, unmoved(own, faulty))
        return Evidence(runs_of, tuple(tuple(changed) for changed in faulty), () if settings.anew else every, every)

    def _going_on(
        self, kept: Learnt, recordings: Recordings, own: Sequence[StoredRun], cases: Sequence[HriCase]
    ) -> Learnt:
        """Without what fails where a run goes on until it is decided, as it does once a suggestion is accepted."""
        tests = {case.concrete.id: case.concrete for case in cases}
        for _ in range(MOST_ROUNDS):
            shown = kept.ranked[: self.settings.most]
            formulas = tuple(one.candidate.formula for one in shown)
            undecided = [tests[name] for name in kept.undecided(shown, own)]
            runs = recordings.of_tests(undecided, "tests that go on until suggestions are decided", formulas)
            refuted = {name for run in runs for name in run.failed}.intersection(formulas)
            if not refuted:
                break
            kept = kept.without_formulas(refuted)
        return kept

    def _refuting(self, best: Sequence[Rated], cases: Sequence[HriCase], most: int) -> list[ConcreteTest]:
        """Tests to refute the best candidates: those that came nearest to it, with other parameters."""
        nearest = Counter(rated.tally.nearest for rated in best if rated.tally.nearest)
        # A further test is named after the test of the session that it is a variant of.
        by_id = {case.abstract.id: case for case in cases}
        names = [name if name in by_id else name.rpartition("-k")[0] for name, _ in nearest.most_common()]
        first = [by_id[name] for name in dict.fromkeys(names) if name in by_id]
        rest = [case for case in cases if case not in first]
        return further_tests([*first, *rest], most, start=self.settings.further)

    def _described(self, shown: Sequence[Rated], kept: Learnt) -> list[Suggestion]:
        names, noticed, made = {*self.session.context.texts}, kept.evidence.taken, []
        number = 0
        for rated in shown:
            number += 1
            while f"S{number}" in names:
                number += 1
            tally, candidate = rated.tally, rated.candidate
            made.append(
                Suggestion(
                    id=f"S{number}",
                    title=candidate.title,
                    formula=candidate.formula,
                    form=candidate.form,
                    triggers=tally.triggers,
                    decisive=tally.decisive,
                    margin=None if tally.least is None else round(tally.least, 6),
                    observed=candidate.observed,
                    faults=rated.faults.bit_count(),
                    new=rated.new.bit_count(),
                    added=(rated.faults & ~noticed).bit_count(),
                    further=kept.further.get(candidate.formula, 0),
                    like=alike(rated, kept.evidence),
                )
            )
            noticed |= rated.faults
        return made
