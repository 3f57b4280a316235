"""Interventions: the code under test with one decision taken the other way, or one call left out, in one run.

What a run does then is an experiment on the code, as leaving an action out is one on its surroundings. A failing run
that passes with one decision switched fails for what leads to this decision (X. Zhang, N. Gupta, R. Gupta: Locating
Faults Through Automated Predicate Switching, ICSE 2006).
"""

from __future__ import annotations

import ast
import os
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

import msgspec

from pytest_hricdv._base.record import Count, PlainRecord
from pytest_hricdv.coverage.code_map import CodeMap
from pytest_hricdv.execution.faults import CodeUnderTest
from pytest_hricdv.execution.instrumented_code import instrument
from pytest_hricdv.extra.diagnosis.runs import RunSummary, in_fork, ran
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.session.replaying import TestRerunner, name_test

DECIDE, MAKES = "__hricdv_decide__", "__hricdv_makes__"
"""What instrumented code calls: of decisions, with the outcome; of calls, to ask whether they are made."""

WAITS = re.compile(r"\b\w*(?:sleep|wait|poll|join|spin)\w*\(")
"""What only waits: without it, a loop would not end."""


class Intervention(PlainRecord, frozen=True, kw_only=True):
    """What is done otherwise in a run.

    Args:
        file: name.
        line: of the statement.
        kind: a decision is taken the other way, or a call is not made.
        number: which time, from 1; None for each time.
    """

    file: str
    line: Count
    kind: Literal["decision", "call"]
    number: Count | None = None

    @property
    def words(self) -> str:
        """What is done otherwise, as it follows a test."""
        if self.kind == "call":
            return "passes without this call"
        return f"passes with this decision reversed{' each time' if self.number is None else ''}"


class InterventionRun(PlainRecord, frozen=True, kw_only=True):
    """A run of instrumented code.

    Args:
        summary: of the run.
        times: what was executed how often until the first violation: interventions with this number are the last.
    """

    summary: RunSummary
    times: tuple[Intervention, ...] = ()


RunOtherwise = Callable[[ConcreteTest, Intervention | None], InterventionRun | None]
"""Runs a test of instrumented code; None where the run came to no end."""

_DECODER: msgspec.json.Decoder[InterventionRun | None] = msgspec.json.Decoder(InterventionRun | None)


def intervene(rerunner: TestRerunner, code: CodeMap) -> RunOtherwise:
    """Runs tests with the code changed in a fork; elsewhere nothing is run.

    Args:
        rerunner: runs tests.
        code: under test.
    """

    def run(test: ConcreteTest, intervention: Intervention | None) -> InterventionRun | None:
        if not hasattr(os, "fork"):
            return None
        return _DECODER.decode(in_fork(rerunner, lambda: _run(rerunner, code, test, intervention)))

    return run


def _run(
    rerunner: TestRerunner, code: CodeMap, test: ConcreteTest, intervention: Intervention | None
) -> InterventionRun | None:
    switch = _Switch(intervention)
    files = [(file.path, file.text, switch.change(file.name)) for file in code.files]
    with instrument(files, {DECIDE: switch.decide, MAKES: switch.makes}):
        result = rerunner.run(name_test(test, "intervention"), switch.begin)
    if result is None:
        return None
    summary = ran(result, rerunner.settings)
    return InterventionRun(summary=summary, times=tuple(switch.until(min(summary.times_s.values(), default=None))))


Site = tuple[str, int, Literal["decision", "call"]]
"""Name of a file, line of a statement, and what it does."""


@dataclass
class _Switch:
    """What instrumented code asks in a run."""

    wanted: Intervention | None
    now_s: Callable[[], float] = lambda: 0.0
    sites: list[Site] = field(default_factory=list)
    times_s: dict[int, list[float]] = field(default_factory=dict)

    def begin(self, code: CodeUnderTest) -> None:
        """See `execute`."""
        self.now_s = lambda: code.now_s

    def change(self, file: str) -> Callable[[ast.Module], ast.Module]:
        """How the tree of a file is changed."""
        return _Instrumenter(file, self.sites).visit

    def decide(self, number: int, outcome: object) -> bool:
        """The outcome of a decision in this run."""
        return bool(outcome) != self._is_otherwise(number)

    def makes(self, number: int) -> bool:
        """Whether a call is made in this run."""
        return not self._is_otherwise(number)

    def _is_otherwise(self, number: int) -> bool:
        times_s = self.times_s.setdefault(number, [])
        times_s.append(self.now_s())
        wanted = self.wanted
        return (
            wanted is not None
            and self.sites[number] == (wanted.file, wanted.line, wanted.kind)
            and wanted.number in (None, len(times_s))
        )

    def until(self, time_s: float | None) -> Iterator[Intervention]:
        """How often each was executed until a time (s); None for all of the run."""
        for number, times_s in sorted(self.times_s.items(), key=lambda entry: self.sites[entry[0]]):
            count = sum(time_s is None or other_s <= time_s for other_s in times_s)
            file, line, kind = self.sites[number]
            if count:
                yield Intervention(file=file, line=line, kind=kind, number=count)


class _Instrumenter(ast.NodeTransformer):
    """Lets each decision and each call of a statement ask."""

    def __init__(self, file: str, sites: list[Site]) -> None:
        self._file = file
        self._sites = sites

    def _ask(self, name: str, kind: Literal["decision", "call"], node: ast.AST, *arguments: ast.expr) -> ast.Call:
        line = node.lineno  # type: ignore[attr-defined]
        self._sites.append((self._file, line, kind))
        number = ast.Constant(len(self._sites) - 1)
        made = ast.Call(ast.Name(name, ast.Load()), [number, *arguments], [])
        return ast.copy_location(made, arguments[0] if arguments else node)

    def _decision(self, node: ast.If | ast.While | ast.IfExp | ast.Assert) -> ast.AST:
        self.generic_visit(node)
        node.test = self._ask(DECIDE, "decision", node, node.test)
        return node

    visit_If = visit_While = visit_IfExp = visit_Assert = _decision  # noqa: N815 (names of `ast.NodeVisitor`)

    def visit_Expr(self, node: ast.Expr) -> ast.AST:
        """A statement that is a call."""
        self.generic_visit(node)
        called = node.value.value if isinstance(node.value, ast.Await) else node.value
        if not isinstance(called, ast.Call) or WAITS.search(ast.unparse(called.func) + "("):
            return node
        return ast.copy_location(ast.If(self._ask(MAKES, "call", node), [node], []), node)


@dataclass
class SwitchSearch:
    """Looks for interventions with which a failing test passes.

    Args:
        run: runs tests otherwise.
        budget: at most so many runs.
    """

    run: RunOtherwise
    budget: int
    used: int = 0

    def search(
        self,
        test: ConcreteTest,
        scores: Mapping[tuple[str, int], float],
        passes: Callable[[RunSummary, RunSummary], bool],
    ) -> list[Intervention]:
        """Those found, the most suspicious first.

        Args:
            test: that fails.
            scores: file and line -> how suspicious; others are not tried.
            passes: whether a run passes, given the run of the test as it is.
        """
        if self.budget < 2:
            return []
        self.used += 1
        control = self.run(test, None)
        if control is None:
            return []
        tried = [site for site in control.times if (site.file, site.line) in scores]
        tried.sort(key=lambda site: -scores[site.file, site.line])
        found = []
        for last in tried:
            for intervention in (last, msgspec.structs.replace(last, number=None)):
                if self.used >= self.budget or (intervention.number is None and last.number == 1):
                    break
                self.used += 1
                made = self.run(test, intervention)
                if made is not None and passes(control.summary, made.summary):
                    found.append(intervention)
                    break
        return found
