"""What no test covers, by cause: a function, the plans of an agent, bins that share values, a requirement.

A list of points says little, as many of them have one cause and are closed together: the largest come first.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from pytest_hricdv.coverage.records import Gap
from pytest_hricdv.report import explanation, holes_view
from pytest_hricdv.report.formatting import natural, plural
from pytest_hricdv.results.model import Report, TestResult

_WAIVED = "waived as unreachable"
_NOUNS = {"statements": "statement", "branches": "branch"}


@dataclass(frozen=True)
class HoleCause:
    """Points that are likely to be closed together.

    Args:
        kind: of the points, as people say it.
        title: what they have in common.
        count: how many they are.
        reason: why they are not covered, as far as that is known.
        reach: what is likely to reach them; empty where nothing is known.
        test: the test that came nearest; None where the report has none.
        command: runs this test again, to be varied; empty without one.
        points: the points of each part, and what is known of it.
    """

    kind: str
    title: str
    count: int
    reason: str
    reach: str
    test: TestResult | None
    command: str
    points: tuple[tuple[str, str], ...]


def hole_causes(report: Report) -> tuple[HoleCause, ...]:
    """All of them, those with most points first."""
    gaps = [gap for gap in report.closure.gaps or () if not gap.reason.startswith(_WAIVED)]
    causes = [*_code(report, gaps), *_bins(report, gaps), *_plans(report, gaps), *_requirements(report, gaps)]
    return tuple(sorted(causes, key=lambda cause: (-cause.count, cause.kind, natural(cause.title))))


def _code(report: Report, gaps: Sequence[Gap]) -> Iterator[HoleCause]:
    """The statements and branches of a function."""
    for place, mine in _by_place(gap for gap in gaps if gap.kind in _NOUNS).items():
        counts = {kind: sum(len(gap.items) for gap in mine if gap.kind == kind) for kind in _NOUNS}
        kind = " and ".join(plural(count, _NOUNS[name]) for name, count in counts.items() if count)
        points = tuple((", ".join(gap.items), gap.suggestion or gap.reason) for gap in mine)
        yield _cause(report, kind, place, mine, points, sum(counts.values()))


def _bins(report: Report, gaps: Sequence[Gap]) -> Iterator[HoleCause]:
    """The bins of a cross product that share values."""
    for product, mine in _by_place(gap for gap in gaps if gap.kind == "bins").items():
        names = {item: gap for gap in mine for item in gap.items}
        if product not in report.cross_products:
            yield _cause(report, plural(len(names), "bin"), product, mine, tuple((name, "") for name in names))
            continue
        for text, bins in holes_view.members_of_all_suites(report, product):
            shown = [(" x ".join(bin_), names[" x ".join(bin_)]) for bin_ in bins if " x ".join(bin_) in names]
            if shown:
                points = tuple((name, gap.suggestion) for name, gap in shown)
                title = f"{product}: {text.removesuffix(f': {len(bins)}')}"
                yield _cause(report, plural(len(shown), "bin"), title, [gap for _, gap in shown], points)


def _plans(report: Report, gaps: Sequence[Gap]) -> Iterator[HoleCause]:
    """The plans of an agent that are not triggered for one reason."""
    reasons: dict[tuple[str, str], list[Gap]] = {}
    for gap in gaps:
        if gap.kind == "plans":
            reasons.setdefault((gap.place, gap.reason), []).append(gap)
    for (agent, _), mine in reasons.items():
        points = tuple((", ".join(gap.items), gap.suggestion) for gap in mine)
        yield _cause(report, plural(len(mine), "plan"), f"plans of {agent}", mine, points)


def _requirements(report: Report, gaps: Sequence[Gap]) -> Iterator[HoleCause]:
    """A requirement that nothing triggered, or alternatives of its response that never decided."""
    for name, mine in _by_place(gap for gap in gaps if gap.kind == "requirements").items():
        items = [item for gap in mine for item in gap.items]
        kind = plural(len(items), "alternative") if items else "requirement"
        yield _cause(report, kind, name, mine, tuple((item, "") for item in items), max(len(items), 1))


def _by_place(gaps: Iterator[Gap]) -> dict[str, list[Gap]]:
    places: dict[str, list[Gap]] = {}
    for gap in gaps:
        places.setdefault(gap.place, []).append(gap)
    return places


def _cause(
    report: Report,
    kind: str,
    title: str,
    gaps: Sequence[Gap],
    points: tuple[tuple[str, str], ...],
    count: int | None = None,
) -> HoleCause:
    nearest = next((gap.test for gap in gaps if gap.test), "")
    test = next((test for test in report.tests if test.id == nearest), None) if nearest else None
    suites = {suite.name: suite.seed for suite in report.suites}
    command = ""
    if test is not None and report.rerun.suite and test.suite in suites:
        seed = suites[test.suite]
        command = explanation.generate_command(test.nodeid, report.rerun.suite, seed, report.rerun.options)
    return HoleCause(
        kind=kind,
        title=title,
        count=len(points) if count is None else count,
        reason="; ".join(dict.fromkeys(gap.reason for gap in gaps)),
        reach=next((gap.suggestion for gap in gaps if gap.suggestion), ""),
        test=test,
        command=command,
        points=points,
    )
