"""Predicate switching: reruns a failing test with one branch decision of the code under test reversed.

This is an experiment on the code, as leaving an action out is one on its surroundings. A run that passes with one
decision reversed fails for what leads to this decision (X. Zhang, N. Gupta, R. Gupta: Locating Faults Through Automated
Predicate Switching, ICSE 2006).
"""

from __future__ import annotations

import ast
import os
from bisect import bisect_left, bisect_right
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import msgspec

from pytest_hricdv._base.record import Count, Number, PlainRecord
from pytest_hricdv.coverage.code_map import CodeMap
from pytest_hricdv.execution.faults import CodeUnderTest
from pytest_hricdv.execution.instrumented_code import instrument
from pytest_hricdv.extra.diagnosis.runs import RunSummary, in_fork, ran
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.monitor.verdict import Verdict
from pytest_hricdv.session.replaying import TestRerunner, name_test

DECIDE = "__hricdv_decide__"
"""What instrumented code calls with the outcome of a decision."""

AROUND_S = 0.5
"""A decision is reversed from so long (s) before a requirement asks for something, as it may have been taken before.
Chosen."""

Place = tuple[str, int]
"""Name of a file, and first line of a statement."""

AFTER_S = 5.0
"""It is reversed until so long (s) after the requirement no longer asks: what goes otherwise comes later. Chosen."""

CONFIRMING = 4
"""Of the runs that are left, one in so many is for a second test."""

SWITCHED = "passes with this decision reversed"


class DecisionSwitch(PlainRecord, frozen=True, kw_only=True):
    """A decision that comes out otherwise in a run, once at each instant: a loop that polls may not go on for ever.

    Args:
        file: name.
        line: of the statement.
        first: which time it is taken (from 1) that is changed first.
        until_s: none is changed after this (s).
        outcome: what it comes out as.
    """

    file: str
    line: Count
    first: Count
    until_s: Number
    outcome: bool

    @property
    def place(self) -> Place:
        """Of the statement."""
        return self.file, self.line


class SwitchedRun(PlainRecord, frozen=True, kw_only=True):
    """A run of instrumented code.

    Args:
        summary: of the run.
        switches: of each decision that was taken before the violation: to reverse its last outcome as long as the
            requirement asks for what does not come; then, if that is another thing, the last time alone.
    """

    summary: RunSummary
    switches: tuple[DecisionSwitch, ...] = ()


RunSwitched = Callable[[ConcreteTest, DecisionSwitch | None], SwitchedRun | None]
"""Runs a test of instrumented code; None where the run came to no end."""

_DECODER: msgspec.json.Decoder[SwitchedRun | None] = msgspec.json.Decoder(SwitchedRun | None)


def make_switch_runner(rerunner: TestRerunner, code: CodeMap, requirement: str) -> RunSwitched:
    """Runs tests with the code changed in a fork; where there is none, nothing is run.

    Args:
        rerunner: runs tests.
        code: under test.
        requirement: that is violated.
    """

    def run(test: ConcreteTest, wanted: DecisionSwitch | None) -> SwitchedRun | None:
        if not hasattr(os, "fork"):
            return None
        return _DECODER.decode(in_fork(rerunner, lambda: _run(rerunner, code, test, wanted, requirement)))

    return run


def _run(
    rerunner: TestRerunner, code: CodeMap, test: ConcreteTest, wanted: DecisionSwitch | None, requirement: str
) -> SwitchedRun | None:
    asked = DecisionRecord(wanted)
    files = [(file.path, file.text, asked.change(file.name)) for file in code.files]
    with instrument(files, {DECIDE: asked.decide}):
        result = rerunner.run(name_test(test, "switched"), asked.begin)
    if result is None:
        return None
    summary = ran(result, rerunner.settings)
    if wanted is not None:
        return SwitchedRun(summary=summary)
    verdict = next((verdict for verdict in result.verdicts if verdict.requirement == requirement), None)
    return SwitchedRun(summary=summary, switches=tuple(asked.switches(*_window(verdict, result.sim_s))))


def _window(verdict: Verdict | None, end_s: float) -> tuple[float, float, float]:
    """From when on something was asked for that did not come, when this was a violation, and until when it was (s)."""
    if verdict is None or not verdict.violations:
        return end_s, end_s, end_s
    first = verdict.violations[0]
    ends_s = [trigger.end_s for trigger in verdict.history if trigger.begin_s == first.trigger_s]
    return first.trigger_s - AROUND_S, first.time_s, max(first.time_s, *ends_s, first.trigger_s) + AFTER_S


@dataclass
class DecisionRecord:
    """What instrumented code asks in a run.

    Args:
        wanted: the decision to reverse; None for none.
    """

    wanted: DecisionSwitch | None
    now_s: Callable[[], float] = lambda: 0.0
    sites: list[tuple[str, int]] = field(default_factory=list)
    """File and line of each decision in the text."""
    times_s: dict[int, list[float]] = field(default_factory=dict)
    """Number of a site -> when it was decided."""
    outcomes: dict[int, list[bool]] = field(default_factory=dict)
    """Number of a site -> how."""
    _switched_s: float = -1.0

    def begin(self, code: CodeUnderTest) -> None:
        """See `execute`."""
        self.now_s = lambda: code.now_s

    def change(self, file: str) -> Callable[[ast.Module], ast.Module]:
        """How the tree of a file is changed."""
        return _DecisionInserter(file, self.sites).visit

    def decide(self, number: int, outcome: object, is_condition: bool = True) -> object:
        """The outcome of a decision in this run; a value that is no bool decides nothing."""
        if not is_condition and not isinstance(outcome, bool):
            return outcome
        now_s = self.now_s()
        self.times_s.setdefault(number, []).append(now_s)
        self.outcomes.setdefault(number, []).append(bool(outcome))
        wanted = self.wanted
        if wanted is None or not self._is_wanted(wanted, number, now_s):
            return outcome
        self._switched_s = now_s
        return wanted.outcome

    def _is_wanted(self, wanted: DecisionSwitch, number: int, now_s: float) -> bool:
        if self.sites[number] != wanted.place or len(self.times_s[number]) < wanted.first:
            return False
        return self._switched_s < now_s <= wanted.until_s

    def switches(self, from_s: float, violated_s: float, until_s: float) -> Iterator[DecisionSwitch]:
        """See `SwitchedRun`."""
        for number, times_s in sorted(self.times_s.items(), key=lambda entry: self.sites[entry[0]]):
            count, before = bisect_right(times_s, violated_s), bisect_left(times_s, from_s)
            if not count:
                continue
            file, line = self.sites[number]
            outcome = not self.outcomes[number][count - 1]
            if before < count:
                yield DecisionSwitch(file=file, line=line, first=before + 1, until_s=until_s, outcome=outcome)
            if before + 1 != count:
                yield DecisionSwitch(file=file, line=line, first=count, until_s=times_s[count - 1], outcome=outcome)


_VALUES = ast.Compare | ast.BoolOp | ast.UnaryOp | ast.Call | ast.Attribute | ast.Name | ast.Await
"""What may be a decision as the value of a `return` or an assignment; whether it is one shows in the run."""


class _DecisionInserter(ast.NodeTransformer):
    """Lets each decision ask."""

    def __init__(self, file: str, sites: list[tuple[str, int]]) -> None:
        self._file = file
        self._sites = sites

    def _wrap(self, node: ast.AST, value: ast.expr, *more: ast.expr) -> ast.expr:
        self._sites.append((self._file, node.lineno))  # type: ignore[attr-defined]
        asked = ast.Call(ast.Name(DECIDE, ast.Load()), [ast.Constant(len(self._sites) - 1), value, *more], [])
        return ast.copy_location(asked, value)

    def _decision(self, node: ast.If | ast.While | ast.IfExp | ast.Assert) -> ast.AST:
        self.generic_visit(node)
        node.test = self._wrap(node, node.test)
        return node

    def _value(self, node: ast.Return | ast.Assign) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.value, _VALUES):
            node.value = self._wrap(node, node.value, ast.Constant(False))
        return node

    visit_If = visit_While = visit_IfExp = visit_Assert = _decision  # noqa: N815 (names of `ast.NodeVisitor`)
    visit_Return = visit_Assign = _value  # noqa: N815


@dataclass(frozen=True)
class SwitchResult:
    """A decision with which tests pass, if it comes out otherwise.

    Args:
        place: of it.
        changes: how many messages and changes of signals are other ones then.
        callers: how many other such decisions only pass on what it decides.
    """

    place: Place
    changes: int
    callers: int


Passes = Callable[[RunSummary, RunSummary, float], bool]
"""Whether a run passes until a time (s), given the run of the same test as it is first."""


@dataclass
class SwitchSearch:
    """Looks for decisions without which failing tests pass.

    Args:
        run: runs tests.
        budget: at most so many runs.
    """

    run: RunSwitched
    budget: int
    used: int = 0

    def search(
        self,
        tests: Sequence[tuple[ConcreteTest, Passes]],
        scores: Mapping[Place, float],
        calls: Callable[[Place, Place], bool],
    ) -> list[SwitchResult]:
        """File and line of those found; those come first that change least of what is seen of a run.

        Each lets each of the tests pass.

        Args:
            tests: that fail for one cause.
            scores: file and line -> how suspicious; others are not tried.
            calls: whether a statement calls the function of another one, so that it only passes on what that decides.
        """
        if not scores:
            return []
        found: dict[Place, int] = dict.fromkeys(scores, 0)
        for number, (test, passes) in enumerate(tests):
            control = self._run(test, None) if found else None
            if control is None:
                return []
            kept = 0 if number + 1 == len(tests) else (self.budget - self.used) // CONFIRMING
            lets_pass: dict[Place, int] = {}
            for switch in _in_order(control, found, scores):
                if switch.place in lets_pass or self.used + kept >= self.budget:
                    continue
                made = self._run(test, switch)
                if made is not None and passes(control.summary, made.summary, switch.until_s):
                    lets_pass[switch.place] = found[switch.place] + _differences(control.summary, made.summary)
            found = lets_pass
        made_of = [SwitchResult(place, changes, len(_callers(place, found, calls))) for place, changes in found.items()]
        return sorted(made_of, key=lambda switch: (switch.changes, -switch.callers, -scores[switch.place]))

    def _run(self, test: ConcreteTest, switch: DecisionSwitch | None) -> SwitchedRun | None:
        if self.used >= self.budget:
            return None
        self.used += 1
        return self.run(test, switch)


def _in_order(control: SwitchedRun, found: Mapping[Place, int], scores: Mapping[Place, float]) -> list[DecisionSwitch]:
    """The most suspicious decisions first: each as long as something is asked for, then the last time alone."""
    wanted = [switch for switch in control.switches if switch.place in found]
    wanted.sort(key=lambda switch: (found[switch.place], -scores[switch.place]))
    firsts = {(switch.place, switch.outcome): switch for switch in reversed(wanted)}
    return [*reversed(firsts.values()), *(switch for switch in wanted if switch not in firsts.values())]


def _callers(place: Place, found: Iterable[Place], calls: Callable[[Place, Place], bool]) -> set[Place]:
    """Those found that pass on what a statement decides, themselves or through others."""
    callers: set[Place] = set()
    new = {place}
    while new:
        new = {other for other in found for called in new if calls(other, called)} - callers - {place}
        callers |= new
    return callers


def _differences(control: RunSummary, made: RunSummary) -> int:
    """How many messages and changes of signals only one of two runs has: a robot that gives up changes most."""
    seen = [Counter((event.stream, event.value) for event in run.events) for run in (control, made)]
    return sum(((seen[0] - seen[1]) + (seen[1] - seen[0])).values())
