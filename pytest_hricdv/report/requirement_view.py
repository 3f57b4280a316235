"""`RequirementView`: what the page (`html`) and the sheet show of a requirement, such as its state and margins."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args

from pytest_hricdv.monitor import NearMiss, RequirementResult
from pytest_hricdv.report.formatting import by_requirement
from pytest_hricdv.report.totals import find_xfail_reason
from pytest_hricdv.report.view import RequirementNote, views
from pytest_hricdv.report.violations import NO_TEXT, margin_unit
from pytest_hricdv.results.model import NcExemption, Report, RequirementText, TestResult

SHOWN = 25
"""Most failures, tight passes and near misses that are listed of each; the table of tests has the others."""
_SPANS_S = (0.1, 0.5, 1, 2, 5, 10, 20, 60, 300, 1800, 86400)
"""Widths that the bars of a histogram of times may have (s): round ones, so that people can read them off."""

RequirementState = Literal["failed", "known to fail", "not checked", "not checked, as allowed", "pending", "passed"]

STATES: tuple[RequirementState, ...] = get_args(RequirementState)
"""The states of requirements, the worst first."""

_STYLES: Mapping[RequirementState, str] = {
    "failed": "bad",
    "known to fail": "warn",
    "not checked": "warn",
    "not checked, as allowed": "",
    "pending": "warn",
    "passed": "ok",
}

Judged = tuple[TestResult, RequirementResult]
Missed = tuple[TestResult, NearMiss]
"""A test with its result for the requirement, or with its nearest miss."""


@dataclass(frozen=True)
class RequirementView:
    """A requirement; `failures`, `tight` and `near_misses` hold at most `SHOWN` tests each, the worst first.

    Attributes:
        texts: its title, source and formula.
        known_reason: why, and under which condition, its violation is known; empty if it is not.
        outside: how many tests violated it outside of this condition.
        until: the last day on which it is; empty if that is not limited.
        allowed_untriggered: why no test need trigger it; None if one must.
        counts: verdict -> number of tests.
        triggers: over all tests.
        pending: those that were undecided at the end of a run.
        tight: tests that passed with the least margins.
        near_misses: tests that did not trigger it, by how near they came.
        notes: the notes of features.
        unit: the unit of its margin; empty if that is not known.
        least: the least margin of all tests; None where nothing was compared.
    """

    name: str
    texts: RequirementText
    known_reason: str
    outside: int
    until: str
    allowed_untriggered: NcExemption | None
    counts: Mapping[str, int]
    triggers: int
    pending: int
    failures: tuple[Judged, ...]
    tight: tuple[Judged, ...]
    near_misses: tuple[Missed, ...]
    notes: tuple[RequirementNote, ...]
    unit: str
    least: float | None

    @property
    def state(self) -> RequirementState:
        """Its state over all tests; the worst counts."""
        if self.counts["Failed"]:
            return "known to fail" if self.known_reason and not self.outside else "failed"
        if self.counts["Passed"]:
            return "passed"
        if self.pending:
            return "pending"
        return "not checked, as allowed" if self.allowed_untriggered else "not checked"

    @property
    def style(self) -> str:
        """The badge style of its state."""
        return _STYLES[self.state]

    @property
    def search_text(self) -> str:
        """The words that a search finds it by."""
        texts = self.texts
        return " ".join((self.name, texts.title, texts.group, texts.source, self.state)).lower()

    @property
    def new_failures(self) -> int:
        """Tests that violated it where that is not known."""
        return self.outside if self.known_reason else self.counts["Failed"]

    @property
    def xfails(self) -> int:
        """Tests that violated it only where that is known."""
        return self.counts["Failed"] - self.new_failures


def requirement_view(report: Report, name: str) -> RequirementView:
    """One requirement, over all tests of the report."""
    pairs = [(test, test.requirements[name]) for test in report.tests if name in test.requirements]
    by_verdict = {word: [pair for pair in pairs if pair[1].verdict == word] for word in ("Passed", "Failed", "NC")}
    tight = [pair for pair in by_verdict["Passed"] if pair[1].margin is not None]
    near_misses = [(test, result.near_miss) for test, result in by_verdict["NC"] if result.near_miss]
    return RequirementView(
        name=name,
        texts=report.requirements.get(name, NO_TEXT),
        known_reason=find_xfail_reason(report, name),
        outside=sum(result.outside for _, result in by_verdict["Failed"]),
        until=report.known_until.get(name, ""),
        allowed_untriggered=report.allowed_untriggered.get(name),
        counts={word: len(judged) for word, judged in by_verdict.items()},
        triggers=sum(result.triggers for _, result in pairs),
        pending=sum(result.pending for _, result in pairs),
        failures=tuple(sorted(by_verdict["Failed"], key=_margin)[:SHOWN]),
        tight=tuple(sorted(tight, key=_margin)[:SHOWN]),
        near_misses=tuple(sorted(near_misses, key=_nearness)[:SHOWN]),
        notes=tuple(note for view in views() if (note := view.of_requirement(report, name)) is not None),
        unit=margin_unit(report, name),
        least=min((result.margin for _, result in pairs if result.margin is not None), default=None),
    )


def group_requirements(requirements: Iterable[RequirementView]) -> list[tuple[str, list[RequirementView]]]:
    """The requirements by their group, in the order of their first ones.

    Those without a group come first, without a heading: below one they would seem to be of that group.
    """
    groups: dict[str, list[RequirementView]] = {"": []}
    for view in requirements:
        groups.setdefault(view.texts.group, []).append(view)
    return [(group, members) for group, members in groups.items() if members]


def states(requirements: Iterable[RequirementView]) -> dict[RequirementState, int]:
    """State -> how many requirements have it, the worst first; without those that none has."""
    counts = Counter(view.state for view in requirements)
    return {state: counts[state] for state in STATES if counts[state]}


def triggers_over_time(report: Report, requirement: str, bins: int = 60) -> dict[str, Any] | None:
    """How often a requirement triggered in each span of simulated time, suite by suite; None if it never did.

    Returns:
        As plain data: `width_s` of a span, and `suites`: name -> triggers in each span from 0 s on.
    """
    begins: dict[str, list[float]] = {}
    for test in report.tests:
        triggers = test.timeline.triggers.get(requirement, "") if test.timeline else ""
        begins.setdefault(test.suite, []).extend(float(span.partition("-")[0]) for span in triggers.split())
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


def plot_texts(report: Report, name: str) -> dict[str, Any]:
    """The texts on a failed requirement for the page of a test: its title and formula, the names it reads, its limits.

    Args:
        report: the report that has it.
        name: the requirement's name.
    """
    texts = report.requirements.get(name, NO_TEXT)
    return {
        "title": texts.title,
        "formula": texts.text,
        "reads": texts.reads,
        "limits": [(limit.name, limit.relation, limit.value) for limit in texts.limits],
    }
