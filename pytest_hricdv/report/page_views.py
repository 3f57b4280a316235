"""The views of requirements and of sources on the page of the report."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from operator import add
from typing import Any, Literal

from pytest_hricdv.coverage.records import MappedFile, ReportedNearMiss, RequirementResult
from pytest_hricdv.report.formatting import by_requirement
from pytest_hricdv.report.tests_view import code_bits, plan_bits, plan_names
from pytest_hricdv.report.totals import known
from pytest_hricdv.results.model import ModelSource, NcExemption, Report, RequirementText, TestResult
from pytest_hricdv.results.searching import SearchResult

SHOWN = 25
"""At most so many failures, tight passes and near misses are listed; the table of tests has the others."""
_NO_TEXT = RequirementText(title="", source="", text="")
_SPANS_S = (0.1, 0.5, 1, 2, 5, 10, 20, 60, 300, 1800, 86400)

Judged = tuple[TestResult, RequirementResult]
Missed = tuple[TestResult, ReportedNearMiss]

LineKind = Literal["hit", "missed", "partial", "waived", ""]


@dataclass(frozen=True)
class RequirementView:
    """A requirement; `failures`, `tight` and `near_misses` hold at most `SHOWN` tests each, the worst first.

    Attributes:
        texts: its title, source and formula.
        known: why, and under which condition, its violation is known; empty if it is not.
        outside: how many tests violated it outside of this condition.
        until: the last day on which it is; empty if that is not limited.
        may_be_nc: why no test need trigger it; None where one must.
        counts: verdict -> number of tests.
        triggers: over all tests.
        tight: tests that passed with the least margins.
        near_misses: tests that did not trigger it, by how near they came.
        searched: the result of a search for a violation; None if there was none.
        unit: of its margin; empty where that is not known.
    """

    name: str
    texts: RequirementText
    known: str
    outside: int
    until: str
    may_be_nc: NcExemption | None
    counts: Mapping[str, int]
    triggers: int
    failures: tuple[Judged, ...]
    tight: tuple[Judged, ...]
    near_misses: tuple[Missed, ...]
    searched: SearchResult | None
    unit: str


def requirement_view(report: Report, name: str) -> RequirementView:
    """One requirement, over all tests of the report."""
    pairs = [(test, test.requirements[name]) for test in report.tests if name in test.requirements]
    by_verdict = {word: [pair for pair in pairs if pair[1].verdict == word] for word in ("Passed", "Failed", "NC")}
    tight = [pair for pair in by_verdict["Passed"] if pair[1].margin is not None]
    near_misses = [(test, result.nearest_miss) for test, result in by_verdict["NC"] if result.nearest_miss]
    return RequirementView(
        name=name,
        texts=report.requirements.get(name, _NO_TEXT),
        known=known(report, name),
        outside=sum(result.outside for _, result in by_verdict["Failed"]),
        until=report.known_until.get(name, ""),
        may_be_nc=report.may_be_nc.get(name),
        counts={word: len(found) for word, found in by_verdict.items()},
        triggers=sum(result.triggers for _, result in pairs),
        failures=tuple(sorted(by_verdict["Failed"], key=_margin)[:SHOWN]),
        tight=tuple(sorted(tight, key=_margin)[:SHOWN]),
        near_misses=tuple(sorted(near_misses, key=_nearness)[:SHOWN]),
        searched=report.search.get(name),
        unit=margin_unit(report, name),
    )


def margin_unit(report: Report, name: str) -> str:
    """The unit of a requirement's margins: seconds for a deadline, else that of the signals it compares."""
    response = report.requirements.get(name, _NO_TEXT).text.partition("->")[2]
    if "eventually" in response:
        return "s"
    units = report.units or {}
    named = {units[word] for word in re.findall(r"[A-Za-z_][\w.]*", response) if word in units}
    return named.pop() if len(named) == 1 else ""


def triggers_over_time(report: Report, requirement: str, bins: int = 60) -> dict[str, Any] | None:
    """How often a requirement triggered in each span of simulated time, suite by suite; None if it never did.

    Returns:
        As plain data: `width_s` of a span, and `suites`: name -> triggers in each span from 0 s on.
    """
    begins: dict[str, list[float]] = {}
    for test in report.tests:
        attempts = test.timeline.attempts.get(requirement, "") if test.timeline else ""
        begins.setdefault(test.suite, []).extend(float(each.partition("-")[0]) for each in attempts.split())
    last_s = max((time_s for times in begins.values() for time_s in times), default=None)
    if last_s is None:
        return None
    width_s = next(width for width in (*_SPANS_S, last_s + 1) if width * bins > last_s)
    counts = {name: [0] * (int(last_s / width_s) + 1) for name in sorted(begins, key=by_requirement) if begins[name]}
    for name, times in begins.items():
        for time_s in times:
            counts[name][int(time_s / width_s)] += 1
    return {"width_s": width_s, "suites": counts}


def _margin(judged: Judged) -> tuple[bool, float, str]:
    test, result = judged
    return result.margin is None, result.margin or 0.0, test.id


def _nearness(missed: Missed) -> tuple[int, bool, float, str]:
    test, miss = missed
    return len(miss.missing), miss.distance is None, miss.distance or 0.0, test.id


@dataclass(frozen=True)
class SourceLine:
    """One line of a source text.

    Attributes:
        number: from 1.
        text: without its end.
        kind: "partial" is a line with a branch that was never taken; empty for a line without a statement or plan.
        unit: number of the statement or plan among all, for links to the tests that reach it; None if it has none.
        tests: how many tests reach it.
        note: what the page writes beside it.
    """

    number: int
    text: str
    kind: LineKind = ""
    unit: int | None = None
    tests: int = 0
    note: str = ""


@dataclass(frozen=True)
class Source:
    """A file with its lines; `covered` of `total` statements or plans were reached."""

    title: str
    file: str
    lines: tuple[SourceLine, ...]
    covered: int
    total: int


def code_sources(report: Report) -> tuple[Source, ...]:
    """The files under test; empty where nothing was measured."""
    if not any(test.code for test in report.tests):
        return ()
    files = report.code_under_test.map
    statements, branches = zip(*map(code_bits, report.tests), strict=True)
    hits = count_bits(statements, sum(len(file.statements) for file in files))
    taken = count_bits(branches, sum(len(file.branches) for file in files))
    waived = {(waiver.file, waiver.line) for waiver in report.code_under_test.waivers}
    sources, first, first_branch = [], 0, 0
    for file in files:
        file_waived = {line for name, line in waived if name == file.file}
        next_first, next_branch = first + len(file.statements), first_branch + len(file.branches)
        untaken = _untaken(file, taken[first_branch:next_branch], file_waived)
        sources.append(_code_source(file, first, hits, untaken, file_waived))
        first, first_branch = next_first, next_branch
    return tuple(source for source in sources if source.total)


def model_sources(report: Report) -> tuple[Source, ...]:
    """The agents' sources."""
    names = plan_names(report)
    numbers = {plan: number for number, plan in enumerate(names)}
    hits = count_bits((plan_bits(test, numbers) for test in report.tests), len(names))
    sources = []
    for agent, model in sorted(report.models.items()):
        lines = {line: label for label, line in model.plans.items() if (agent, label) in numbers}
        units = {line: numbers[agent, label] for line, label in lines.items()}
        notes = {line: _trigger_note(report, agent, label) for line, label in lines.items()}
        covered = sum(hits[unit] > 0 for unit in units.values())
        sources.append(
            Source(f"Agent {agent}", model.file, tuple(_model_lines(model, units, hits, notes)), covered, len(units))
        )
    return tuple(sources)


def count_bits(sets: Iterable[int], size: int) -> list[int]:
    """How many of the bit sets have each of the first `size` bits."""
    counts, number = [0] * size, 0
    for number, bits in enumerate(sets, start=1):  # noqa: B007
        counts = list(map(add, counts, f"{bits:0{size}b}"[::-1].encode()))
    return [count - number * ord("0") for count in counts]


def _untaken(file: MappedFile, taken: Sequence[int], waived: Set[int]) -> dict[int, list[str]]:
    """Line -> ends of the branches from it that no test took."""
    ends: dict[int, list[str]] = {}
    for (start, end), tests in zip(file.branches, taken, strict=True):
        if not tests and start not in waived and end not in waived:
            ends.setdefault(start, []).append("to the exit" if end < 0 else f"to line {end}")
    return ends


def _code_source(
    file: MappedFile, first: int, hits: Sequence[int], untaken: Mapping[int, Sequence[str]], waived: Set[int]
) -> Source:
    """A file whose first statement has this number."""
    units = {line: unit for unit, line in enumerate(file.statements, start=first)}
    lines = []
    for number, text in enumerate(file.source.splitlines(), start=1):
        unit = units.get(number)
        if unit is None:
            lines.append(SourceLine(number, text))
        elif number in waived:  # the line itself holds the reason
            lines.append(SourceLine(number, text, "waived", unit, hits[unit]))
        elif hits[unit] and number in untaken:
            note = f"branch never taken: {', '.join(untaken[number])}"
            lines.append(SourceLine(number, text, "partial", unit, hits[unit], note))
        else:
            lines.append(SourceLine(number, text, "hit" if hits[unit] else "missed", unit, hits[unit]))
    covered = sum(hits[unit] > 0 for unit in units.values())
    return Source(file.file, "", tuple(lines), covered, len(units))


def _trigger_note(report: Report, agent: str, label: str) -> str:
    """The smallest belief set of any suite that triggers a plan, else one that exploration of the model found."""
    plans = (suite.plans[agent] for suite in report.suites if agent in suite.plans)
    reached = [each.reached[label].shortest for each in plans if label in each.reached]
    smallest = min(reached, key=lambda beliefs: (len(beliefs), beliefs), default=None)
    if smallest:
        return f"triggered by {' '.join(smallest)}"
    found = (report.exploration.plans or {}).get(agent, {}).get(label)
    return f"would be triggered by {' '.join(found)}" if found and smallest is None else ""


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
