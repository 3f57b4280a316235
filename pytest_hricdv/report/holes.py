"""Coverage holes, grouped by cause: a function, the plans of an agent, bins that share values, a requirement.

`hole_causes` lists them for the page (`html`), those with most points of each kind first. `totals` and `plot_data` take
the holes of cross products from here.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Literal, NamedTuple
from urllib.parse import quote

from pytest_hricdv.coverage.cross_product import Bin, ProductDeclaration
from pytest_hricdv.coverage.gaps import Hole, holes
from pytest_hricdv.coverage.records import Gap
from pytest_hricdv.report import explanation
from pytest_hricdv.report.formatting import natural, plural
from pytest_hricdv.results.model import Report, SuiteResult, TestResult

_WAIVED = "waived as unreachable"
_NOUNS = {"statements": "statement", "branches": "branch"}


HoleGroup = Literal["code", "requirements", "plans", "bins"]


@dataclass(frozen=True)
class HoleCause:
    """Points that are likely to be closed together.

    Args:
        group: the group of the points' kind.
        address: the address of the view that shows them in their place; of code, that of its file.
        kind: the kind of the points, as people say it.
        title: what they have in common.
        count: how many they are.
        reason: why they are not covered, as far as that is known.
        reach: what is likely to reach them; empty where nothing is known.
        test: the test that came nearest; None if the report has none.
        command: runs this test again, to be varied; empty without one.
        points: the points of each part, and what is known of it.
    """

    group: HoleGroup
    address: str
    kind: str
    title: str
    count: int
    reason: str
    reach: str
    test: TestResult | None
    command: str
    points: tuple[tuple[str, str], ...]

    def address_of(self, point: str) -> str:
        """Where a point is shown: of code, its first line."""
        line = re.match(r"\d+", point)
        return f"{self.address}@{line[0]}" if self.group == "code" and line else self.address


def hole_causes(report: Report) -> tuple[HoleCause, ...]:
    """All causes: code first, then requirements, plans and bins; within each, those with most points first."""
    gaps = [gap for gap in report.closure.gaps or () if not gap.reason.startswith(_WAIVED)]
    kinds = (_code(report, gaps), _requirements(report, gaps), _plans(report, gaps), _bins(report, gaps))
    return tuple(
        cause
        for causes in kinds
        for cause in sorted(causes, key=lambda cause: (-cause.count, cause.kind, natural(cause.title)))
    )


def _code(report: Report, gaps: Sequence[Gap]) -> Iterator[HoleCause]:
    """The statements and branches of a function."""
    for place, mine in _by_place(gap for gap in gaps if gap.kind in _NOUNS).items():
        counts = {kind: sum(len(gap.items) for gap in mine if gap.kind == kind) for kind in _NOUNS}
        kind = " and ".join(plural(count, _NOUNS[name]) for name, count in counts.items() if count)
        points = tuple((", ".join(gap.items), gap.suggestion or gap.reason) for gap in mine)
        group = _Group("code", f"code/{quote(place.partition(' ')[0], safe='')}")
        yield _cause(report, group, kind, place, mine, points, sum(counts.values()))


def _bins(report: Report, gaps: Sequence[Gap]) -> Iterator[HoleCause]:
    """The bins of a cross product that share values."""
    for name_of_product, mine in _by_place(gap for gap in gaps if gap.kind == "bins").items():
        names = {item: gap for gap in mine for item in gap.items}
        if name_of_product not in report.cross_products:
            points = tuple((name, "") for name in names)
            yield _cause(report, _BINS, plural(len(names), "bin"), name_of_product, mine, points)
            continue
        for text, bins in members_of_all_suites(report, name_of_product):
            shown = [(" x ".join(bin_), names[" x ".join(bin_)]) for bin_ in bins if " x ".join(bin_) in names]
            if shown:
                points = tuple((name, gap.suggestion) for name, gap in shown)
                title = f"{name_of_product}: {text.removesuffix(f': {len(bins)}')}"
                yield _cause(report, _BINS, plural(len(shown), "bin"), title, [gap for _, gap in shown], points)


def _plans(report: Report, gaps: Sequence[Gap]) -> Iterator[HoleCause]:
    """The plans of an agent that are not triggered for one reason."""
    reasons: dict[tuple[str, str], list[Gap]] = {}
    for gap in gaps:
        if gap.kind == "plans":
            reasons.setdefault((gap.location, gap.reason), []).append(gap)
    for (agent, _), mine in reasons.items():
        points = tuple((", ".join(gap.items), gap.suggestion) for gap in mine)
        yield _cause(
            report,
            _Group("plans", f"plans/{quote(f'Agent {agent}', safe='')}"),
            plural(len(mine), "plan"),
            f"plans of {agent}",
            mine,
            points,
        )


def _requirements(report: Report, gaps: Sequence[Gap]) -> Iterator[HoleCause]:
    """A requirement that nothing triggered, or alternatives of its response that never decided."""
    for name, mine in _by_place(gap for gap in gaps if gap.kind == "requirements").items():
        items = [item for gap in mine for item in gap.items]
        kind = plural(len(items), "alternative") if items else "requirement"
        points = tuple((item, "") for item in items)
        yield _cause(
            report,
            _Group("requirements", f"requirement/{quote(name, safe='')}"),
            kind,
            name,
            mine,
            points,
            max(len(items), 1),
        )


def _by_place(gaps: Iterator[Gap]) -> dict[str, list[Gap]]:
    places: dict[str, list[Gap]] = {}
    for gap in gaps:
        places.setdefault(gap.location, []).append(gap)
    return places


class _Group(NamedTuple):
    kind: HoleGroup
    address: str


_BINS = _Group("bins", "cross")


def _cause(
    report: Report,
    group: _Group,
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
    if test is not None and report.rerun_options.suite and test.suite in suites:
        seed = suites[test.suite]
        command = explanation.generate_command(
            test.nodeid, report.rerun_options.suite, seed, report.rerun_options.options
        )
    return HoleCause(
        group=group.kind,
        address=group.address,
        kind=kind,
        title=title,
        count=len(points) if count is None else count,
        reason="; ".join(dict.fromkeys(gap.reason for gap in gaps)),
        reach=next((gap.suggestion for gap in gaps if gap.suggestion), ""),
        test=test,
        command=command,
        points=points,
    )


# Holes of cross products in words, the largest first


def holes_of_suite(report: Report, suite: SuiteResult) -> Iterator[str]:
    """The holes of a suite, over all products."""
    several = len(suite.cross.products) > 1
    for name, coverage in suite.cross.products.items():
        hit = {hits.bin for hits in coverage.hits}
        for text in _texts(report.cross_products[name], coverage.missing, hit):
            yield f"{name}: {text}" if several else text


def holes_of_all_suites(report: Report, name: str) -> tuple[str, ...]:
    """The holes of one product that no suite hit."""
    declared = report.cross_products[name]
    return tuple(_texts(declared, *_split_bins(report, name)))


def members_of_all_suites(report: Report, name: str) -> Iterator[tuple[str, tuple[Bin, ...]]]:
    """The holes with the bins that no larger hole has."""
    declared = report.cross_products[name]
    missing, hit = _split_bins(report, name)
    places = {coordinate.name: place for place, coordinate in enumerate(declared.coordinates)}
    left = dict.fromkeys(missing)
    if not left:
        return
    for hole in holes([*places], _open_bins(declared, hit), missing):
        mine = tuple(bin_ for bin_ in left if all(bin_[places[of]] == value for of, value in hole.values))
        for bin_ in mine:
            del left[bin_]
        if mine:
            yield _text(hole, len(places)), mine


def _split_bins(report: Report, name: str) -> tuple[list[Bin], set[Bin]]:
    """The bins of a product that no suite hit, and those that one did."""
    covered = [suite.cross.products[name] for suite in report.suites if name in suite.cross.products]
    hit = {hits.bin for coverage in covered for hits in coverage.hits}
    open_bins = _open_bins(report.cross_products[name], hit) if covered else []
    return [bin_ for bin_ in open_bins if bin_ not in hit], hit


def _texts(declared: ProductDeclaration, missing: Collection[Bin], hit: Collection[Bin]) -> Iterator[str]:
    names = [coordinate.name for coordinate in declared.coordinates]
    if missing:
        yield from (_text(hole, len(names)) for hole in holes(names, _open_bins(declared, hit), missing))


def _open_bins(declared: ProductDeclaration, hit: Collection[Bin]) -> list[Bin]:
    """The bins to be hit. What was proved impossible and hit nevertheless is one of them."""
    impossible = {record.bin for record in declared.impossible} - set(hit)
    closed = impossible | {record.bin for record in declared.illegal}
    return [bin_ for bin_ in product(*(coordinate.bins for coordinate in declared.coordinates)) if bin_ not in closed]


def _text(hole: Hole, coordinates: int) -> str:
    if len(hole.values) == coordinates:
        return " x ".join(value for _, value in hole.values)
    if not hole.values:
        return f"all {plural(hole.bins, 'bin')}"
    return f"every bin with {' and '.join(f'{name} {value}' for name, value in hole.values)}: {hole.bins}"
