"""Runs the model with all belief sets, and says which bins are impossible, and which beliefs reach a plan or bin.

A bin of a cross product that no run of the model reaches is impossible, and does not count as a gap of coverage. A
report gets the impossible bins from `explore`; the closing loop chooses belief sets by the runs of `explore_model`, or
of `sample_model` if there are too many. If not all runs can be explored, nothing is proven.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

from pytest_hricdv._base import sealed_cache
from pytest_hricdv.coverage.closure import declare
from pytest_hricdv.coverage.code_map import CoverageError
from pytest_hricdv.coverage.cross_product import (
    Bin,
    CrossProduct,
    ExplorationRecord,
    PlannedBin,
    ProductDeclaration,
    Proof,
)
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.context import GenerationContext
from pytest_hricdv.generate.model import Exploration

CACHE_KEY = "hricdv/exploration-{}"
"""Key of an exploration in pytest's cache; the fingerprint of the model and its belief space completes it."""


@dataclass(frozen=True)
class Reachability:
    """The results of an exploration, as in the keys `exploration` and `cross_products` of a report."""

    exploration: ExplorationRecord = field(default_factory=ExplorationRecord)
    products: Mapping[str, ProductDeclaration] = field(default_factory=dict)


def explore(context: GenerationContext, products: Mapping[str, CrossProduct], cache: Any | None) -> Reachability:
    """Explore a model, or take its exploration from the cache, and compare it with the cross products.

    Args:
        context: the model, its belief space, and the human's commands.
        products: the cross products of the testbench.
        cache: `config.cache`, or None if the cache plugin is off.

    Raises:
        CoverageError: a cross product's `planned` returned something other than values of its first coordinates.
    """
    try:
        exploration = explore_model(context, cache)
    except GenerateError as error:
        exploration = Exploration(reason=f"the model cannot be explored: {error}")
    return reachable(exploration, products)


def reachable(exploration: Exploration, products: Mapping[str, CrossProduct]) -> Reachability:
    """The results of an exploration for cross products. Raises CoverageError, see `explore`."""
    planned = {name: _plan(name, product, exploration) for name, product in products.items() if product.planned}
    proof = Proof(
        status="proven" if exploration.complete else "not proven", reason=exploration.reason, runs=len(exploration.runs)
    )
    declared = {
        name: declare(
            product, proof if product.planned else Proof(), _impossible(product, planned.get(name), exploration)
        )
        for name, product in products.items()
    }
    bins = {
        name: tuple(PlannedBin(bin=bin_, beliefs=beliefs) for bin_, beliefs in sorted(bins.items()))
        for name, bins in planned.items()
    }
    record = ExplorationRecord(
        status=proof.status, reason=proof.reason, runs=proof.runs, plans=_plans(exploration), bins=bins
    )
    return Reachability(record, declared)


def skip_exploration(products: Mapping[str, CrossProduct]) -> Reachability:
    """The cross products as declared, where the model was not explored."""
    return Reachability(products={name: declare(product, Proof(), {}) for name, product in products.items()})


def explore_model(context: GenerationContext, cache: Any | None) -> Exploration:
    """Explore a model, or take its exploration from the cache. Raises GenerateError if the model fails."""

    def explore_now() -> Exploration:
        from pytest_hricdv.generate.model_runner import explore_exhaustively  # it loads the BDI engine

        return explore_exhaustively(context.model_runner())

    return _keep("exploration", context, cache, explore_now)


def sample_model(context: GenerationContext, reason: str, cache: Any | None) -> Exploration:
    """Runs of a model that cannot be explored, with random belief sets; or from the cache.

    Args:
        reason: why the model cannot be explored.

    Raises:
        GenerateError: the model fails with each belief set.
    """

    def sample_now() -> Exploration:
        from pytest_hricdv.generate.model_runner import explore_by_sampling  # it loads the BDI engine

        return explore_by_sampling(context.model_runner(), reason)

    return _keep("sampled exploration", context, cache, sample_now)


def _keep(
    name: str, context: GenerationContext, cache: Any | None, explore_now: Callable[[], Exploration]
) -> Exploration:
    key = CACHE_KEY.format(context.fingerprint(name))
    kept = sealed_cache.read(cache, key)
    if kept is not None:
        try:
            return Exploration.from_json(kept)
        except GenerateError:
            pass  # written by another version, or cut off: explore again
    exploration = explore_now()
    sealed_cache.write(cache, key, exploration.to_json())
    return exploration


def _plans(exploration: Exploration) -> dict[str, dict[str, tuple[str, ...]]]:
    """Agent -> plan -> the smallest belief set found that triggers it; runs come with small sets first."""
    plans: dict[str, dict[str, tuple[str, ...]]] = {}
    seen = 0
    for run in exploration.runs:
        if not run.plans & ~seen:
            continue
        beliefs = exploration.belief_set(run.beliefs)
        for place, (agent, label) in enumerate(exploration.plans):
            if (run.plans & ~seen) >> place & 1:
                plans.setdefault(agent, {})[label] = beliefs
        seen |= run.plans
    return plans


def _plan(name: str, product: CrossProduct, exploration: Exploration) -> dict[Bin, tuple[str, ...]]:
    """The bins planned by abstract tests -> the smallest belief set found that leads to it."""
    assert product.planned is not None
    smallest: dict[Bin, tuple[str, ...]] = {}
    size: int | None = None
    for run in exploration.runs:
        for bin_ in product.planned(run.lines):
            planned = tuple(bin_)
            if planned not in smallest:
                size = len(planned) if size is None else size
                _check(name, product, planned, size)
                smallest[planned] = exploration.belief_set(run.beliefs)
    return smallest


def _check(name: str, product: CrossProduct, planned: Bin, size: int) -> None:
    kinds = [*islice(product.coordinates.items(), len(planned))]
    if len(planned) != size or not 0 < len(planned) <= len(product.coordinates):
        raise CoverageError(
            f"cross product {name!r}: planned returned {planned}; expected a value of each of the same coordinates"
        )
    for part, (coordinate, bins) in zip(planned, kinds, strict=True):
        if part not in bins:
            raise CoverageError(
                f"cross product {name!r}: planned returned {planned}, but {coordinate!r} has no value {part!r}"
            )


def _impossible(
    product: CrossProduct, planned: Mapping[Bin, tuple[str, ...]] | None, exploration: Exploration
) -> dict[Bin, str]:
    """The bins that no run of the model plans; none unless the exploration is complete."""
    if planned is None or not exploration.complete:
        return {}
    size = max(map(len, planned), default=0)
    names = " x ".join(islice(product.coordinates, size))
    reason = f"none of the model's {len(exploration.runs)} runs has this {names}"
    return {bin_: reason for bin_ in product.bins() if bin_[:size] not in planned}
