"""Locating: repairs of the most suspicious statements are tried, with tests that fail for a cause and with others."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from pytest_hricdv.coverage.code_map import CodeMap, SourceFile
from pytest_hricdv.extra.diagnosis.experiments import Experiments
from pytest_hricdv.extra.diagnosis.grouping import Group, Spectra
from pytest_hricdv.extra.diagnosis.hints import FailingTest, Hint, PassingTest, Repairing
from pytest_hricdv.extra.diagnosis.places import Place, readers
from pytest_hricdv.extra.diagnosis.records import Mended
from pytest_hricdv.extra.diagnosis.repairs import Repair, repairs
from pytest_hricdv.extra.diagnosis.runs import RunChanged
from pytest_hricdv.extra.diagnosis.spectrum import Suspect
from pytest_hricdv.report.formatting import plural
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.session.feature import FeatureSession

MOST_PLACES = 5
"""So many of the most suspicious statements are shown."""

MOST_REPAIRED = 10
"""So many are repaired, while runs are left: what mends is shown, wherever it was (chosen: twice the places shown)."""

_AT_ONCE = {"condition changed": 2, "call added": 2, "number changed": 6}
"""Kinds of repairs that have many of one statement -> so many are tried one after the other: a condition and its
contrary, a call before and after, a number that is less and more, by a little and by much."""


@dataclass
class Locating:
    """Tries repairs within the runs that experiments have left.

    Args:
        session: runs tests.
        experiments: that have been made; further runs are counted with theirs.
        spectra: what each test executes.
        tests: node id -> result, of all tests.
        run: runs a test with a repair.
    """

    session: FeatureSession
    experiments: Experiments
    spectra: Spectra
    tests: Mapping[str, TestResult]
    run: RunChanged

    def hints(self, group: Group, ranked: Sequence[Suspect], budget: int) -> list[Hint]:
        """Repairs of a cause that stand all tests; none on a system where nothing can be forked.

        Args:
            group: the cause.
            ranked: statements, the most suspicious first.
            budget: at most so many runs.
        """
        if budget < 1 or not hasattr(os, "fork") or self.experiments.ended == "interrupted":
            return []  # to write down all repairs of five statements takes as long as some runs
        failing = [*self._failing(group)]
        if not failing:
            return []
        repairing = Repairing(self.run, budget)
        try:
            return repairing.hints(
                ordered(self.session.context.code, ranked), failing, lambda repair: [*self._passing(group, repair)]
            )
        except KeyboardInterrupt:
            self.experiments.ended = "interrupted"
            return []
        finally:
            self.experiments.used += repairing.used

    def joined(self, groups: Sequence[Group], hints: Sequence[Sequence[Hint]]) -> Iterator[Mended]:
        """Failures of several causes that one repair mends: they have one.

        Args:
            groups: the causes.
            hints: the repairs of each.
        """
        for number, group in enumerate(groups):
            for hint in (hint for hint in hints[number] if hint.unchanged):
                own = [*self._failing(group)][: hint.mended]
                others = [other for other in groups if other != group and not other.is_known]
                mended = [test for other in others for test in self._mended(hint.repair, other)]
                repair = f"{hint.repair.file}:{hint.repair.line} {hint.repair.words}"
                for test in (*own, *mended) if mended else ():
                    for requirement in sorted(test.wanted):
                        yield Mended(nodeid=test.nodeid, requirement=requirement, repair=repair)

    def _mended(self, repair: Repair, group: Group) -> Sequence[FailingTest]:
        experiments = self.experiments
        repairing = Repairing(self.run, experiments.budget - experiments.used)
        try:
            return repairing.mended(repair, [*self._failing(group)]) if experiments.ended != "interrupted" else ()
        except KeyboardInterrupt:
            experiments.ended = "interrupted"
            return ()
        finally:
            experiments.used += repairing.used

    def _failing(self, group: Group) -> Iterator[FailingTest]:
        """Tests that fail for a cause, the shortest first; those first that failed again as they were."""
        experiments = self.experiments
        wanted: dict[str, set[str]] = {}
        for failure in group.failures:
            wanted.setdefault(failure.nodeid, set()).add(failure.requirement)
        names = [name for name in group.nodeids if name in experiments.tests]
        for name in sorted(names, key=lambda name: (name not in experiments.controls, *experiments.length(name))):
            control = experiments.controls.get(name)
            if name not in experiments.controls:
                violated = {*self._violated(name)} | wanted[name]
                yield FailingTest(experiments.tests[name], wanted[name], violated, name)
            elif control is not None and wanted[name] <= {*control.violated}:
                yield FailingTest(experiments.tests[name], wanted[name], control.violated, name, control)

    def _passing(self, group: Group, repair: Repair) -> Iterator[PassingTest]:
        """Tests that a repair may change and that do not fail for the cause, the shortest first."""
        chosen, affected = self.session.aggregation.chosen, self._affected(repair)
        names = [
            name
            for name, bits in self.spectra.bits.items()
            if name in chosen and name not in group.nodeids and bits.statements & affected
        ]
        for name in sorted(names, key=lambda name: (self.tests[name].fails, len(self.tests[name].abstract), name)):
            checked = [key for key, result in self.tests[name].requirements.items() if result.verdict == "Passed"]
            yield PassingTest(chosen[name].concrete, checked, [*self._violated(name)])

    def _violated(self, name: str) -> Iterator[str]:
        test = self.tests[name]
        yield from (requirement for requirement in test.requirements if test.violates(requirement))

    def _affected(self, repair: Repair) -> int:
        """Bits of the repaired statement; of a constant, which all tests execute, of the statements that read it."""
        files, place = self.session.context.code.files, (repair.file, repair.line)
        reading = {*dict(readers(files, {place})).get(place, ())}
        return sum(1 << number for number, other in enumerate(_places(files)) if other in (reading or {place}))


def _places(files: Sequence[SourceFile]) -> Iterator[Place]:
    """Of all statements, in the order of their bits."""
    return ((file.name, line) for file in files for line in file.statements)


def share_of_first(runs: int, failing: Sequence[int]) -> int:
    """So many runs the first of some causes gets: half of them are the same for each, half go by their failing tests.

    Args:
        runs: of all causes.
        failing: the number of failing tests of each, the first one's first.
    """
    return int(runs * (1.0 / len(failing) + failing[0] / sum(failing)) / 2.0)


def ordered(code: CodeMap, ranked: Sequence[Suspect]) -> list[Repair]:
    """The repairs of the first places: first the usual ones of the first place, last the unusual ones of the last.

    What is usual depends on the statement: of a constant, it is another number. One repair of each kind comes before
    the second one of a kind. A constant is repaired when the first statement that reads it is: it is as suspicious, and
    has few repairs.
    """
    files = {file.name: file for file in code.files}
    ranks = {(suspect.file, suspect.line): rank for rank, suspect in enumerate(ranked)}
    first_read = {
        constant: min((ranks[place] for place in reading if place in ranks), default=len(ranks))
        for constant, reading in readers(code.files, ranks)
    }
    made: list[tuple[int, int, Repair]] = []
    for place, rank in ranks.items():
        earliest = min(rank, first_read.get(place, rank))
        if earliest >= MOST_REPAIRED:
            continue
        counts: dict[str, int] = {}
        for repair in repairs(code.files, files[place[0]], place[1]):
            nth = counts[repair.operator] = counts.get(repair.operator, -1) + 1
            kind = [*counts].index(repair.operator)
            made.append((earliest + kind + nth // _AT_ONCE.get(repair.operator, 1), rank, repair))
    first: dict[str, Repair] = {}  # what comes after a statement comes before the next one: the same program
    for _, _, repair in sorted(made, key=lambda entry: entry[:2]):
        first.setdefault(repair.text, repair)
    return [*first.values()]


def words_of(hint: Hint, failing: int) -> str:
    """A hint as a sentence.

    Args:
        hint: the repair, and what came of it.
        failing: how many tests fail for the cause.
    """
    where = f"{hint.repair.function} ({hint.repair.file}:{hint.repair.line})"
    others = f", none of {plural(hint.unchanged, 'other')} changes" if hint.unchanged else ", no other was run"
    tried = "" if hint.mended == failing else f" of {hint.mended} tried"
    return f"{hint.repair.words} in {where}, {hint.mended}{tried or f' of {failing}'} failing tests pass{others}"


def raised(ranked: Sequence[Suspect], hints: Sequence[Hint]) -> list[Suspect]:
    """The statements in their order, but those first of which a repair stands all tests."""
    mended = [(hint.repair.file, hint.repair.line) for hint in hints if hint.unchanged or hint.mended > 1]
    order = {place: number for number, place in reversed([*enumerate(mended)])}
    return sorted(ranked, key=lambda suspect: order.get((suspect.file, suspect.line), len(order)))
