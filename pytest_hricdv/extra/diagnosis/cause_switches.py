"""Evidence on causes from reversed branch decisions."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from pytest_hricdv.extra.diagnosis.experiments import Experiments
from pytest_hricdv.extra.diagnosis.failures import FAULT
from pytest_hricdv.extra.diagnosis.grouping import Group
from pytest_hricdv.extra.diagnosis.locations import rank_places, traces_of, variation_coverage
from pytest_hricdv.extra.diagnosis.pair_search import PairSearch
from pytest_hricdv.extra.diagnosis.runs import RunSummary
from pytest_hricdv.extra.diagnosis.subject import Subject
from pytest_hricdv.extra.diagnosis.switching import SwitchSearch, make_switch_runner
from pytest_hricdv.session.feature import FeatureSession

SWITCHED_TESTS = 2
"""A reversed decision must let this many tests of a cause pass, if it has as many: one may pass by chance."""


def switch_decisions(
    session: FeatureSession, subject: Subject, experiments: Experiments, decisions: PairSearch, groups: Sequence[Group]
) -> None:
    """Look for decisions of the code without which tests of each cause pass, while runs are left."""
    run = make_switch_runner(session.rerunner, session.context.code)
    groups = [group for group in groups if not group.is_known]
    for place, group in enumerate(groups):
        names = sorted({*group.nodeids} & experiments.tests.keys(), key=experiments.length)
        names = sorted(names, key=lambda name: name not in decisions.minimal)[:SWITCHED_TESTS]
        if not names:
            continue
        ranked = rank_places(subject, group, traces_of(experiments, group), variation_coverage(experiments, group))
        scores = {(suspect.file, suspect.line): suspect.score for suspect in ranked}
        search = SwitchSearch(run, (experiments.budget - experiments.used) // (len(groups) - place))
        tests = []
        for name in names:
            minimal = decisions.minimal.get(name)
            test = experiments.tests[name] if minimal is None else minimal.test
            wanted = {failure.requirement for failure in group.failures if failure.nodeid == name}
            tests.append((test, partial(_passes, wanted)))
        try:
            experiments.switched[group.first] = search.search(tests, scores)
        except KeyboardInterrupt:
            experiments.ended = "interrupted"
            return
        finally:
            experiments.used += search.used
        _compare(experiments, group, names, groups[:place])


def _passes(wanted: set[str], control: RunSummary, made: RunSummary) -> bool:
    """Whether a run passes what the control violates, and all that this passes: a robot that does nothing does not."""
    violated = wanted & {*control.violated}
    return bool(violated) and not made.violated and {*control.checked, *(violated - {FAULT})} <= {*made.checked}


def _compare(experiments: Experiments, group: Group, names: Sequence[str], before: Sequence[Group]) -> None:
    """Note that causes are one: the same decision, the most suspicious of each, lets the tests of both pass."""
    first = experiments.switched[group.first][:1]
    for other in before:
        if first and first == experiments.switched.get(other.first, [])[:1]:
            experiments.together.add((names[0], group.first[0], other.first[0]))
