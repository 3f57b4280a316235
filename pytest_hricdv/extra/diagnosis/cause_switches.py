"""Evidence on causes from reversed branch decisions."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import partial

from pytest_hricdv.coverage.code_map import CodeMap
from pytest_hricdv.coverage.gaps import functions
from pytest_hricdv.extra.diagnosis.experiments import Experiments
from pytest_hricdv.extra.diagnosis.failures import FAULT
from pytest_hricdv.extra.diagnosis.grouping import Group
from pytest_hricdv.extra.diagnosis.locations import is_sure, rank_places, traces_of, variation_coverage
from pytest_hricdv.extra.diagnosis.pair_search import PairSearch
from pytest_hricdv.extra.diagnosis.runs import RunSummary
from pytest_hricdv.extra.diagnosis.subject import Subject
from pytest_hricdv.extra.diagnosis.switching import Passes, Place, SwitchSearch, make_switch_runner
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.session.feature import FeatureSession

SWITCHED_TESTS = 2
"""A reversed decision must let this many tests of a cause pass, if it has as many: one may pass by chance."""


def switch_decisions(
    session: FeatureSession, subject: Subject, experiments: Experiments, decisions: PairSearch, groups: Sequence[Group]
) -> None:
    """Look for decisions of the code without which tests of each cause pass, while runs are left."""
    groups = [group for group in groups if not group.is_known]
    for place, group in enumerate(groups):
        names = sorted({*group.nodeids} & experiments.tests.keys(), key=experiments.length)
        names = sorted(names, key=lambda name: name not in decisions.minimal)[:SWITCHED_TESTS]
        if not names:
            continue
        ranked = rank_places(subject, group, traces_of(experiments, group), variation_coverage(experiments, group))
        scores = {(suspect.file, suspect.line): suspect.score for suspect in ranked}
        run = make_switch_runner(session.rerunner, session.context.code, group.first[0])
        search = SwitchSearch(run, (experiments.budget - experiments.used) // (len(groups) - place))
        tests: list[tuple[ConcreteTest, Passes]] = []
        for test_name in names:
            minimal = decisions.minimal.get(test_name)
            test = experiments.tests[test_name] if minimal is None or tests else minimal.test
            wanted = {failure.requirement for failure in group.failures if failure.nodeid == test_name}
            tests.append((test, partial(passes_until, wanted)))
        if len(tests) == 1:  # what is left of a test says little of what else the robot does
            tests.append((experiments.tests[names[0]], tests[0][1]))
        try:
            experiments.switched[group.first] = search.search(tests, scores, partial(calls, session.context.code))
        except KeyboardInterrupt:
            experiments.ended = "interrupted"
            return
        finally:
            experiments.used += search.used
        _compare(experiments, group, names, groups[:place])


def passes_until(wanted: set[str], control: RunSummary, made: RunSummary, until_s: float) -> bool:
    """Whether a run passes what the control violates for a cause, and all that this passes: not a robot that rests.

    What the control violates for other causes may fail again, and the same cause later, where nothing was reversed.
    """
    violated = wanted & {*control.violated}
    other = {*control.violated} - violated
    reversed_then = {name for name in violated if control.times_s.get(name, until_s) < until_s}
    later = {name for name in reversed_then if made.times_s.get(name, until_s) > until_s}
    may_fail, asked = other | later, {*control.checked, *(violated - {FAULT})}
    return bool(violated) and {*made.violated} <= may_fail and asked <= {*made.checked} | later


def _compare(experiments: Experiments, group: Group, names: Sequence[str], before: Sequence[Group]) -> None:
    """Note that causes are one: the same decision, the most suspicious of each, lets the tests of both pass."""
    mine = experiments.switched[group.first]
    for other in before:
        theirs = experiments.switched.get(other.first, [])
        if is_sure(mine) and is_sure(theirs) and mine[0].place == theirs[0].place:
            experiments.together.add((names[0], group.first[0], other.first[0]))


def calls(code: CodeMap, place: Place, other: Place) -> bool:
    """Whether a statement calls the function that another one is in, by its name."""
    texts = {file.name: file for file in code.files}
    file, line = texts[place[0]], place[1]
    end = next((first for first in sorted(file.statements) if first > line), line + 1)
    text = "\n".join(file.text.splitlines()[line - 1 : end - 1])
    name = next(function.name for function in functions(texts[other[0]].text) if other[1] in function)
    return place != other and re.search(rf"\b{re.escape(name.rpartition('.')[2])}\(", text) is not None
