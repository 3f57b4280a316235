"""`EnginesView` shows in the terminal and on the page how far two physics engines agree over the tests of a report."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import zip_longest

from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.engines.feature import CROSS_CHECK, EngineComparison
from pytest_hricdv.report.formatting import Line, by_requirement, natural, percent, plural, share, wrap
from pytest_hricdv.report.tests_view import anchor
from pytest_hricdv.report.view import PageSection, View
from pytest_hricdv.report.violations import margin_text, margin_unit
from pytest_hricdv.results.model import Report, TestResult


@dataclass(frozen=True)
class VerdictAgreement:
    """How far two engines agree on a requirement.

    Args:
        tests: number of tests that ran on both.
        same: those of them with the same verdict.
        tolerated: the others whose margins differ by no more than the testbench allows.
        triggers: tests with the same number of triggers.
        margin: largest difference of margins, in the requirement's own unit; None if no test has both.
    """

    tests: int
    same: int
    tolerated: int
    triggers: int
    margin: float | None


@dataclass(frozen=True)
class Agreement:
    """How far two engines agree over some tests.

    Args:
        engines: their names.
        tests: number of tests that ran on both.
        interactions: number of interactions of these tests, on the engine with more of them.
        same: those that ended alike.
        verdicts: requirement -> how far its verdicts agree.
        differing: test id -> what depends on the engine, a sentence each.
    """

    engines: tuple[str, str]
    tests: int
    interactions: int
    same: int
    verdicts: Mapping[str, VerdictAgreement]
    differing: Mapping[str, tuple[str, ...]]


def agreement(tests: Iterable[TestResult]) -> Agreement | None:
    """The agreement of the engines; None if no test ran on two."""
    both = [(test, second) for test in tests if (second := CROSS_CHECK.of(test)) is not None]
    if not both:
        return None
    ends = [pair for test, second in both for pair in zip_longest(test.outcomes, second.outcomes)]
    return Agreement(
        engines=(both[0][0].engine, both[0][1].engine),
        tests=len(both),
        interactions=len(ends),
        same=sum(first == second for first, second in ends),
        verdicts={name: _verdicts_agreement(name, both) for name in both[0][1].requirements},
        differing={
            test.id: tuple(difference.text for difference in second.differences)
            for test, second in both
            if second.differences or second.errors
        },
    )


def _verdicts_agreement(name: str, both: list[tuple[TestResult, EngineComparison]]) -> VerdictAgreement:
    pairs = [(test.requirements[name], second.requirements[name]) for test, second in both]
    margins = [
        abs(first.margin - second.margin)
        for first, second in pairs
        if first.margin is not None and second.margin is not None
    ]
    differences = [difference for _, second in both for difference in second.differences if difference.what == name]
    return VerdictAgreement(
        tests=len(pairs),
        same=sum(first.verdict == second.verdict for first, second in pairs),
        tolerated=sum(difference.tolerated for difference in differences),
        triggers=sum(first.triggers == second.triggers for first, second in pairs),
        margin=max(margins, default=None),
    )


_MAX_TESTS = 8
_INDENT = "    "


class EnginesView(View):
    """The view of the engines' agreement, and of differences on a test's page."""

    name = "engines"

    def lines(self, report: Report, columns: int) -> Iterator[Line]:
        """Lines on the engines' agreement, and the first tests that depend on the engine; none if tests ran on one."""
        agreed = agreement(report.tests)
        if agreed is None:
            return
        yield Line(f"engines: {plural(agreed.tests, 'test')} on {' and '.join(agreed.engines)}", "title")
        alike = f"{agreed.same} of {agreed.interactions} end alike{_percent(agreed.same, agreed.interactions)}"
        yield Line(visible(f"  {report.outcome_label}: {alike}"))
        pairs, same = (
            sum(getattr(verdicts, name) for verdicts in agreed.verdicts.values()) for name in ("tests", "same")
        )
        yield Line(f"  verdicts: {same} of {pairs} agree{_percent(same, pairs)}")
        for name in sorted(agreed.verdicts, key=natural):
            if agreed.verdicts[name].same < agreed.verdicts[name].tests:
                yield Line(visible(f"  {name}: {_describe(agreed.verdicts[name], margin_unit(report, name))}"), "warn")
        yield from _tests_that_differ(agreed, columns)

    def section(self, report: Report) -> PageSection | None:
        """The verdicts that depend on the engine, and the agreement for each requirement."""
        agreed = agreement(report.tests)
        if agreed is None:
            return None
        names = sorted(agreed.verdicts, key=lambda name: (_share(agreed.verdicts[name]), by_requirement(name)))
        values = {
            "meaning": meaning(agreed),
            "agreed": agreed,
            "differing": {name: agreed.differing[name] for name in sorted(agreed.differing, key=natural)},
            "verdicts": {name: agreed.verdicts[name] for name in names},
            "anchors": {test.id: anchor(test.nodeid) for test in report.tests},
        }
        return PageSection(
            "engines", "Engines", "engines/engines.html.jinja", values, headline=meaning(agreed).rstrip(".")
        )

    def facts(self, test: TestResult) -> dict[str, str]:
        """The differences between engines."""
        second = CROSS_CHECK.of(test)
        differences = () if second is None else second.differences
        return {"Engines differ": "; ".join(difference.text for difference in differences)}


VIEW = EnginesView()


def meaning(agreed: Agreement) -> str:
    """`1 of 8 tests depends on the engine: pybullet and mujoco agree in 118 of 120 verdicts.`."""
    differing, engines = len(agreed.differing), " and ".join(agreed.engines)
    same = sum(verdicts.same for verdicts in agreed.verdicts.values())
    pairs = sum(verdicts.tests for verdicts in agreed.verdicts.values())
    who = f"{differing} of {plural(agreed.tests, 'test')} {'depends' if differing == 1 else 'depend'}"
    who = who if differing else f"None of {plural(agreed.tests, 'test')} depends"
    return f"{who} on the engine: {engines} agree in {same} of {plural(pairs, 'verdict')}."


def _share(verdicts: VerdictAgreement) -> float:
    return verdicts.same / verdicts.tests if verdicts.tests else 1.0


def _describe(verdicts: VerdictAgreement, unit: str) -> str:
    text = f"{verdicts.same} of {verdicts.tests} agree"
    text += f", {verdicts.tolerated} within tolerance" if verdicts.tolerated else ""
    return text + (
        f"; margins differ by at most {margin_text(verdicts.margin, unit)}" if verdicts.margin is not None else ""
    )


def _tests_that_differ(agreed: Agreement, columns: int) -> Iterator[Line]:
    for test in sorted(agreed.differing, key=natural)[:_MAX_TESTS]:
        yield Line(visible(f"  {test}"), "warn")
        for text in agreed.differing[test]:
            for line in wrap(visible(text).split(), columns - len(_INDENT)):
                yield Line(f"{_INDENT}{line}")
    if len(agreed.differing) > _MAX_TESTS:
        yield Line(f"  and {plural(len(agreed.differing) - _MAX_TESTS, 'more test')}", "warn")


def _percent(part: int, whole: int) -> str:
    return f" ({percent(share(part, whole))})"
