"""Predicate switching: reruns a failing test with one branch decision of the code under test reversed.

A test that then passes fails for what leads to this decision (X. Zhang, N. Gupta, R. Gupta: Locating Faults Through
Automated Predicate Switching, ICSE 2006). `causes` makes a `SwitchSearch` for each cause, which chooses the decisions,
and gives it the function that `make_switch_runner` returns, which runs a test with a decision reversed.
"""

from __future__ import annotations

import ast
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from types import FunctionType

from pytest_hricdv._base.record import Count, PlainRecord
from pytest_hricdv.coverage.code_map import CodeMap
from pytest_hricdv.execution.faults import CodeUnderTest
from pytest_hricdv.execution.instrumented_code import find_functions, instrument
from pytest_hricdv.extra.diagnosis.runs import RunSummary, in_fork, ran
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.session.replaying import TestRerunner, name_test

DECIDE = "__hricdv_decide__"
"""The function that instrumented code calls with the outcome of a decision."""

SWITCHED = "passes with this decision reversed"
"""`SuspiciousPlace.experiment` of a decision that this search found."""


class DecisionSwitch(PlainRecord, frozen=True, kw_only=True):
    """A decision that is reversed in a run.

    Args:
        line: the statement's line.
        number: from 1, which of the times that the run takes this decision.
    """

    file: str
    line: Count
    number: Count

    @property
    def place(self) -> tuple[str, int]:
        """File and line of the statement."""
        return self.file, self.line


class SwitchedRun(PlainRecord, frozen=True, kw_only=True):
    """A run of instrumented code.

    Args:
        last: the last time that each decision was taken before the first violation.
    """

    summary: RunSummary
    last: tuple[DecisionSwitch, ...] = ()


RunSwitched = Callable[[ConcreteTest, DecisionSwitch | None], SwitchedRun | None]
"""Runs a test of instrumented code; None if the run did not end."""


def make_switch_runner(rerunner: TestRerunner, code: CodeMap) -> RunSwitched:
    """Returns a function that runs a test with the code changed, in a fork; without forks, it runs nothing."""

    @cache
    def functions() -> list[FunctionType]:
        return find_functions(file.path for file in code.files)

    def run(test: ConcreteTest, wanted: DecisionSwitch | None) -> SwitchedRun | None:
        if not hasattr(os, "fork"):
            return None
        before = functions()
        return in_fork(rerunner, lambda: _run(rerunner, code, test, wanted, before), SwitchedRun)

    return run


def _run(
    rerunner: TestRerunner,
    code: CodeMap,
    test: ConcreteTest,
    wanted: DecisionSwitch | None,
    functions: list[FunctionType],
) -> SwitchedRun | None:
    asked = DecisionRecord(wanted)
    files = [(file.path, file.text, asked.change(file.name)) for file in code.files]
    with instrument(files, {DECIDE: asked.decide}, functions):
        result = rerunner.run(name_test(test, "switched"), asked.begin)
    if result is None:
        return None
    summary = ran(result, rerunner.settings)
    return SwitchedRun(summary=summary, last=tuple(asked.until(min(summary.times_s.values(), default=None))))


@dataclass
class DecisionRecord:
    """The record that instrumented code consults in a run.

    Args:
        wanted: the decision to reverse; None for none.
    """

    wanted: DecisionSwitch | None
    now_s: Callable[[], float] = lambda: 0.0
    sites: list[tuple[str, int]] = field(default_factory=list)
    """File and line of each decision in the text."""
    times_s: dict[int, list[float]] = field(default_factory=dict)
    """Number of a site -> when it was decided."""

    def begin(self, code: CodeUnderTest) -> None:
        """See `execute`."""
        self.now_s = lambda: code.now_s

    def change(self, file: str) -> Callable[[ast.Module], ast.Module]:
        """The change of a file's tree."""
        return _DecisionInserter(file, self.sites).visit

    def decide(self, number: int, outcome: object) -> bool:
        """The outcome of a decision in this run."""
        times_s = self.times_s.setdefault(number, [])
        times_s.append(self.now_s())
        wanted = self.wanted
        is_wanted = wanted is not None and self.sites[number] == wanted.place and wanted.number == len(times_s)
        return bool(outcome) != is_wanted

    def until(self, time_s: float | None) -> Iterator[DecisionSwitch]:
        """Each decision, the last time it was taken until a time (s); None for all of the run."""
        for number, times_s in sorted(self.times_s.items(), key=lambda entry: self.sites[entry[0]]):
            count = sum(time_s is None or other_s <= time_s for other_s in times_s)
            file, line = self.sites[number]
            if count:
                yield DecisionSwitch(file=file, line=line, number=count)


class _DecisionInserter(ast.NodeTransformer):
    """Makes each decision of the code consult the record."""

    def __init__(self, file: str, sites: list[tuple[str, int]]) -> None:
        self._file = file
        self._sites = sites

    def _decision(self, node: ast.If | ast.While | ast.IfExp | ast.Assert) -> ast.AST:
        self.generic_visit(node)
        self._sites.append((self._file, node.lineno))
        asked = ast.Call(ast.Name(DECIDE, ast.Load()), [ast.Constant(len(self._sites) - 1), node.test], [])
        node.test = ast.copy_location(asked, node.test)
        return node

    visit_If = visit_While = visit_IfExp = visit_Assert = _decision  # noqa: N815 (names of `ast.NodeVisitor`)


Passes = Callable[[RunSummary, RunSummary], bool]
"""Whether a run passes, given the run of the same test as it is."""


@dataclass
class SwitchSearch:
    """Searches for decisions whose reversal makes failing tests pass.

    Args:
        run: runs tests.
        budget: most runs.
    """

    run: RunSwitched
    budget: int
    used: int = 0

    def search(
        self, tests: Sequence[tuple[ConcreteTest, Passes]], scores: Mapping[tuple[str, int], float]
    ) -> list[tuple[str, int]]:
        """File and line of those found, the most suspicious first; they let each of the tests pass.

        Args:
            tests: the tests that fail for one cause.
            scores: file and line -> how suspicious; others are not tried.
        """
        found, is_first = [*scores], True
        for test, passes in tests:
            control = self._run(test, None) if found else None
            if control is None:
                return [] if is_first else found
            is_first = False
            last = {switch.place: switch for switch in control.last if switch.place in found}
            places = sorted(last, key=lambda place: -scores[place])
            found = [place for place in places if self._lets_pass(test, last[place], control, passes)]
        return found

    def _lets_pass(self, test: ConcreteTest, switch: DecisionSwitch, control: SwitchedRun, passes: Passes) -> bool:
        made = self._run(test, switch)
        return made is not None and passes(control.summary, made.summary)

    def _run(self, test: ConcreteTest, switch: DecisionSwitch | None) -> SwitchedRun | None:
        if self.used >= self.budget:
            return None
        self.used += 1
        return self.run(test, switch)
