"""How high a ranking puts the fault: exact shares, with ties in random order."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Sequence
from math import comb

from pytest_hricdv._base.record import PlainRecord
from pytest_hricdv.coverage.code_map import CodeMap
from pytest_hricdv.coverage.gaps import functions
from pytest_hricdv.extra.diagnosis.records import CAUSES, Cause
from pytest_hricdv.extra.diagnosis.spectrum import ExecutionCounts, ochiai
from pytest_hricdv.extra.diagnosis.subject import Subject
from pytest_hricdv.results.model import Report
from studies.localization.faults import Truth

FIRST = (1, 3, 5)
"""The statement is looked for among the first so many."""

Place = tuple[str, int]
"""Name of a file, and first line of a statement."""


class Hit(PlainRecord, frozen=True, kw_only=True):
    """How probably a ranking points at a fault: its function is the first, its statement is among the first 1, 3, 5."""

    function: float
    statements: tuple[float, ...]


NOWHERE = Hit(function=0.0, statements=(0.0,) * len(FIRST))


def hits(report: Report, truth: Truth) -> dict[str, Hit] | None:
    """Ranking -> how well it does, of the first cause of a report; None where nothing fails but what is known."""
    cause = next((cause for cause in CAUSES.of(report) if not cause.is_known), None)
    code = CodeMap.of(report.code_under_test)
    if cause is None or code is None:
        return None
    counts = dict(_counts(report, cause, code))
    return {
        "diagnosis": _of_order([[(place.file, place.line)] for place in cause.locations], truth, code),
        "ochiai": _of_order(_tied(counts, ochiai), truth, code),
        "dstar": _of_order(_tied(counts, dstar), truth, code),
        "chance": _of_order(_tied(counts, lambda executing: 1.0), truth, code),
    }


def shown_right(report: Report, truth: Truth) -> bool | None:
    """Whether the first statement that the first cause shows is in the faulty function; None where it shows none."""
    cause = next((cause for cause in CAUSES.of(report) if not cause.is_known), None)
    code = CodeMap.of(report.code_under_test)
    if cause is None or code is None or not cause.likely_locations:
        return None
    first = cause.likely_locations[0]
    return bool(_of_order([[(first.file, first.line)]], truth, code).function)


def _counts(report: Report, cause: Cause, code: CodeMap) -> Iterator[tuple[Place, ExecutionCounts]]:
    """The statements that tests of a cause execute."""
    subject = Subject.of(report)
    failing = {test.nodeid for test in report.tests if test.id in cause.tests}
    passing = {*subject.spectra.bits} - {failure.nodeid for failure in subject.failures}
    table = subject.spectra.table
    counts = table.counts(table.statements, table.tests(failing), table.tests(passing))
    places = [(file.name, line) for file in code.files for line in file.statements]
    return ((place, executing) for place, executing in zip(places, counts, strict=True) if executing.failing)


def dstar(counts: ExecutionCounts) -> float:
    """DStar with the exponent 2: from 0 on, infinite for what all failing tests execute and no passing one.

    W. Wong, V. Debroy, R. Gao, Y. Li: The DStar Method for Effective Software Fault Localization, IEEE Transactions on
    Reliability 63(1), 2014.
    """
    others = counts.passing + counts.all_failing - counts.failing
    if not counts.failing:
        return 0.0
    return math.inf if not others else counts.failing**2 / others


def _tied(counts: dict[Place, ExecutionCounts], coefficient: Callable[[ExecutionCounts], float]) -> list[list[Place]]:
    """Statements of the same score, the highest first."""
    groups: dict[float, list[Place]] = {}
    for place, executing in counts.items():
        groups.setdefault(coefficient(executing), []).append(place)
    return [groups[score] for score in sorted(groups, reverse=True)]


def _of_order(groups: Sequence[Sequence[Place]], truth: Truth, code: CodeMap) -> Hit:
    if not groups:
        return NOWHERE
    inner_first = {file.name: functions(file.text) for file in code.files}

    def function(place: Place) -> tuple[str, str]:
        return place[0], next(function.name for function in inner_first[place[0]] if place[1] in function)

    wanted = {(truth.file, line) for line in truth.statements}
    first = {function(place) for place in groups[0]}
    share = sum(name in truth.functions for file, name in first if file == truth.file) / len(first)
    return Hit(function=share, statements=tuple(_among(groups, wanted.__contains__, most) for most in FIRST))


def _among(groups: Sequence[Collection[Place]], is_wanted: Callable[[Place], bool], most: int) -> float:
    """How probably a wanted place is among the first, where the places of a group come in random order."""
    for group in groups:
        wanted = sum(map(is_wanted, group))
        if len(group) >= most or wanted:
            taken = min(most, len(group))
            return 1.0 - comb(len(group) - wanted, taken) / comb(len(group), taken)
        most -= len(group)
    return 0.0
