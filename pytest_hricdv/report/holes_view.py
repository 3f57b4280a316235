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
    covered = [suite.cross.products[name] for suite in report.suites if name in suite.cross.products]
    hit = {hits.bin for coverage in covered for hits in coverage.hits}
    missing = [bin_ for bin_ in _open_bins(declared, hit) if bin_ not in hit] if covered else []
    return tuple(_texts(declared, missing, hit))


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
