"""Holes of cross products in words, the largest first."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from itertools import product

from pytest_hricdv.coverage.cross_records import ProductDeclaration
from pytest_hricdv.coverage.holes import Bin, Hole, holes
from pytest_hricdv.report.formatting import plural
from pytest_hricdv.results.model import Report, SuiteResult


def of_suite(report: Report, suite: SuiteResult) -> Iterator[str]:
    """What a suite hit nothing of, over all products."""
    several = len(suite.cross.products) > 1
    for name, coverage in suite.cross.products.items():
        hit = {hits.bin for hits in coverage.hits}
        for text in _texts(report.cross_products[name], coverage.missing, hit):
            yield f"{name}: {text}" if several else text


def of_all_suites(report: Report, name: str) -> tuple[str, ...]:
    """What no suite hit anything of, of one product."""
    declared = report.cross_products[name]
    return tuple(_texts(declared, *_of_all(report, name)))


def members_of_all_suites(report: Report, name: str) -> Iterator[tuple[str, tuple[Bin, ...]]]:
    """The same with the bins of each hole that no larger one has."""
    declared = report.cross_products[name]
    missing, hit = _of_all(report, name)
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


def _of_all(report: Report, name: str) -> tuple[list[Bin], set[Bin]]:
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
