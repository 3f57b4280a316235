"""Coverage of the declared cross products by a suite: bins that are hit, missing, impossible, illegal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping

from pytest_hricdv.coverage.cross_product import Bin, CrossProduct
from pytest_hricdv.coverage.records import (
    BinHits,
    Coordinate,
    CrossCoverage,
    IllegalBin,
    ImpossibleBin,
    ProductCoverage,
    ProductDeclaration,
    Proof,
)
from pytest_hricdv.coverage.suite_coverage import RunCoverage


def declare(product: CrossProduct, proof: Proof, by_model: Mapping[Bin, str]) -> ProductDeclaration:
    """The record of a declared cross product.

    Args:
        proof: what is known of the model (see `pytest_hricdv.coverage.reachability`).
        by_model: the bins that the model proves impossible, each with the reason.
    """
    impossible = [ImpossibleBin(bin=each, reason=why, by="declared") for each, why in product.ruled_out.items()]
    impossible += [
        ImpossibleBin(bin=each, reason=why, by="model")
        for each, why in by_model.items()
        if each not in product.ruled_out
    ]
    return ProductDeclaration(
        coordinates=tuple(Coordinate(name=name, bins=bins) for name, bins in product.coordinates.items()),
        impossible=tuple(sorted(impossible, key=lambda each: each.bin)),
        illegal=tuple(IllegalBin(bin=each, reason=reason) for each, reason in sorted(product.forbidden.items())),
        proof=proof,
    )


def cross_closure(declared: Mapping[str, ProductDeclaration], runs: Iterable[RunCoverage]) -> CrossCoverage:
    """The cross products of a suite: each one, and all together.

    An illegal bin does not have to be covered. A bin that the model proves impossible and that is nevertheless hit, as
    by a test that no model generated, counts as possible.
    """
    runs = list(runs)
    products = {
        name: _covered(product, [run.cross.get(name, ()) for run in runs]) for name, product in declared.items()
    }
    several = len(products) > 1
    missing = [
        (f"{name}: " if several else "") + " x ".join(each)
        for name, product in products.items()
        for each in product.missing
    ]
    return CrossCoverage(
        bins=sum(product.bins for product in products.values()),
        hit=sum(product.hit for product in products.values()),
        impossible=sum(product.impossible for product in products.values()),
        illegal=sum(product.illegal for product in products.values()),
        missing=tuple(missing),
        products=products,
    )


def _covered(declared: ProductDeclaration, hits_of_runs: Iterable[Iterable[Bin]]) -> ProductCoverage:
    hits: Counter[Bin] = Counter()
    tests: Counter[Bin] = Counter()
    for hit_bins in hits_of_runs:
        hit = [*hit_bins]
        hits.update(hit)
        tests.update(set(hit))
    bins = CrossProduct({each.name: each.bins for each in declared.coordinates}).bins()
    illegal = {each.bin for each in declared.illegal}
    impossible = {each.bin for each in declared.impossible} - set(hits) - illegal
    return ProductCoverage(
        bins=len(bins),
        hit=len(hits.keys() - illegal),
        impossible=len(impossible),
        illegal=len(illegal),
        hits=tuple(BinHits(bin=each, tests=tests[each], hits=hits[each]) for each in sorted(hits)),
        missing=tuple(each for each in bins if each not in hits and each not in impossible | illegal),
    )
