"""Source texts for the page (`html`), line by line with coverage: `code_sources` of code, `model_sources` of agents."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from pytest_hricdv.coverage.records import MappedFile
from pytest_hricdv.report.coverage_formats import FileHits, count_bits, count_hits
from pytest_hricdv.report.tests_view import plan_bits, plan_names
from pytest_hricdv.results.model import ModelSource, Report

LineKind = Literal["hit", "missed", "partial", "waived", ""]


@dataclass(frozen=True)
class SourceLine:
    """One line of a source text.

    Attributes:
        number: from 1.
        text: without its end.
        kind: "partial" is a line with a branch that was never taken; empty for a line without a statement or plan.
        unit: number of the statement or plan among all, for links to the tests that reach it; None if it has none.
        tests: how many tests reach it.
        note: what the page writes next to it.
    """

    number: int
    text: str
    kind: LineKind = ""
    unit: int | None = None
    tests: int = 0
    note: str = ""


@dataclass(frozen=True)
class CoverageCount:
    """How many of the points of a file that have to be covered are; waived ones are neither."""

    covered: int = 0
    total: int = 0

    @property
    def misses(self) -> int:
        """How many are not."""
        return self.total - self.covered

    def __add__(self, other: CoverageCount) -> CoverageCount:
        return CoverageCount(self.covered + other.covered, self.total + other.total)


@dataclass(frozen=True)
class AnnotatedSource:
    """A file with its lines.

    Attributes:
        title: how it is named.
        file: where it is; empty if that is the title.
        lines: the lines of the text.
        units: statements, or plans.
        branches: from line to line; of agents none.
        waived: statements that are.
        note: what is to be said of all of it.
    """

    title: str
    file: str
    lines: tuple[SourceLine, ...]
    units: CoverageCount
    branches: CoverageCount = CoverageCount()
    waived: int = 0
    note: str = ""


def code_sources(report: Report) -> tuple[AnnotatedSource, ...]:
    """The files under test; empty where nothing was measured."""
    if not any(test.code for test in report.tests):
        return ()
    sources, first = [], 0
    for file, file_hits in zip(report.code_under_test.map, count_hits(report), strict=True):
        source = _code_source(file, first, file_hits)
        sources.append(replace(source, note=_file_note(report, file.file)))
        first += len(file.statements)
    return tuple(source for source in sources if source.lines and (source.units.total or source.waived))


def _file_note(report: Report, file: str) -> str:
    code = report.code_under_test
    if file in code.never_imported:
        return "never imported"
    reason = code.unmeasured_files.get(file)
    return f"unmeasured: {reason}" if reason else ""


def model_sources(report: Report) -> tuple[AnnotatedSource, ...]:
    """The agents' sources."""
    names = plan_names(report)
    numbers = {plan: number for number, plan in enumerate(names)}
    hits = count_bits([f"{plan_bits(test, numbers):x}" for test in report.tests], len(names))
    sources = []
    for agent, model in sorted(report.models.items()):
        lines = {line: label for label, line in model.plans.items() if (agent, label) in numbers}
        units = {line: numbers[agent, label] for line, label in lines.items()}
        notes = {line: _trigger_note(report, agent, label) for line, label in lines.items()}
        count = CoverageCount(sum(hits[unit] > 0 for unit in units.values()), len(units))
        sources.append(
            AnnotatedSource(f"Agent {agent}", model.file, tuple(_model_lines(model, units, hits, notes)), count)
        )
    return tuple(sources)


def _code_source(file: MappedFile, first: int, hits: FileHits) -> AnnotatedSource:
    """A file whose first statement has this number."""
    units = {line: unit for unit, line in enumerate(file.statements, start=first)}
    branches = hits.branches or {}
    untaken: dict[int, list[str]] = {}
    for (start, end), tests in branches.items():
        if not tests:
            untaken.setdefault(start, []).append("to the exit" if end < 0 else f"to line {end}")
    lines = []
    for number, text in enumerate(file.source.splitlines(), start=1):
        unit, tests = units.get(number), hits.lines.get(number, 0)
        if unit is None:
            lines.append(SourceLine(number, text))
        elif number in hits.waived:  # the line itself holds the reason
            lines.append(SourceLine(number, text, "waived", unit, hits.waived[number]))
        elif tests and number in untaken:
            note = f"branch never taken: {', '.join(untaken[number])}"
            lines.append(SourceLine(number, text, "partial", unit, tests, note))
        else:
            lines.append(SourceLine(number, text, "hit" if tests else "missed", unit, tests))
    return AnnotatedSource(
        title=file.file,
        file="",
        lines=tuple(lines),
        units=CoverageCount(sum(tests > 0 for tests in hits.lines.values()), len(hits.lines)),
        branches=CoverageCount(sum(tests > 0 for tests in branches.values()), len(branches)),
        waived=len(hits.waived),
    )


def _trigger_note(report: Report, agent: str, label: str) -> str:
    """The smallest belief set of any suite that triggers a plan, else one that exploration of the model found."""
    plans = (suite.plans[agent] for suite in report.suites if agent in suite.plans)
    reached = [agent_plans.reached[label].shortest for agent_plans in plans if label in agent_plans.reached]
    smallest = min(reached, key=lambda beliefs: (len(beliefs), beliefs), default=None)
    if smallest:
        return f"triggered by {' '.join(smallest)}"
    beliefs = (report.exploration.plans or {}).get(agent, {}).get(label)
    return f"would be triggered by {' '.join(beliefs)}" if beliefs and smallest is None else ""


def _model_lines(
    model: ModelSource, units: Mapping[int, int], hits: Sequence[int], notes: Mapping[int, str]
) -> Iterator[SourceLine]:
    kind: LineKind = ""
    for number, text in enumerate(model.source.splitlines(), start=1):
        if number in units:
            tests = hits[units[number]]
            kind = "hit" if tests else "missed"
            yield SourceLine(number, text, kind, units[number], tests, notes[number])
        else:
            # A plan ends at an empty line or a comment line.
            kind = kind if text.strip() and not text.startswith("//") else ""
            yield SourceLine(number, text, kind)
