"""Proving: what the model makes impossible, and which beliefs lead to what is not covered yet."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import islice
from typing import Any

from pytest_hricdv.closure.closing import Entry
from pytest_hricdv.cover.cross import Bin, CrossProduct
from pytest_hricdv.cover.crossed import list_product
from pytest_hricdv.cover.source import CoverError
from pytest_hricdv.generate.context import GenerationContext
from pytest_hricdv.generate.error import GenerateError
from pytest_hricdv.generate.exhaustive_exploration import Exploration, explore_exhaustively
from pytest_hricdv.testbench import Testbench

CACHE_KEY = "hricdv/survey-{}"


@dataclass(frozen=True)
class Proof:
    """What a survey of the model says: for the report's `exploration`, and its `cross_products`."""

    exploration: Entry = field(default_factory=dict)
    products: Entry = field(default_factory=dict)


def prove(testbench: Testbench, cache: Any | None) -> Proof:
    """Survey the testbench's model, or take its survey from the cache, and hold the cross products against it.

    Args:
        cache: `config.cache`, or None where the cache plugin is off.

    Raises:
        CoverError: a cross product's `planned` told what is no bin of its first coordinates.
    """
    try:
        surveyed = _surveyed(testbench, cache)
    except GenerateError as error:
        surveyed = Exploration(reason=f"the model cannot be explored: {error}")
    aims = {name: _aims(name, product, surveyed) for name, product in testbench.cross.items() if product.planned}
    status: Entry = {
        "status": "proven" if surveyed.complete else "not proven",
        "reason": surveyed.reason,
        "runs": len(surveyed.runs),
    }
    products = {
        name: list_product(each, status if each.planned else {}, _impossible(each, aims.get(name), surveyed))
        for name, each in testbench.cross.items()
    }
    bins = {
        name: [{"bin": list(aim), "beliefs": list(beliefs)} for aim, beliefs in sorted(found.items())]
        for name, found in aims.items()
    }
    return Proof({**status, "plans": _plans(surveyed), "bins": bins}, products)


def _surveyed(testbench: Testbench, cache: Any | None) -> Exploration:
    context = GenerationContext(
        model=testbench.model, space=testbench.beliefs, commands=tuple(testbench.concretization.commands)
    )
    key = CACHE_KEY.format(context.fingerprint("survey"))
    kept = cache.get(key, None) if cache is not None else None
    if kept is not None:
        try:
            return Exploration.from_json(kept)
        except GenerateError:
            pass  # written by another version, or cut off: survey again
    found = explore_exhaustively(context.model_runner())
    if cache is not None:
        cache.set(key, found.to_json())
    return found


def _plans(surveyed: Exploration) -> dict[str, dict[str, list[str]]]:
    """Agent -> plan -> the smallest belief set found that triggers it; runs come with small sets first."""
    plans: dict[str, dict[str, list[str]]] = {}
    seen = 0
    for run in surveyed.runs:
        if not run.plans & ~seen:
            continue
        beliefs = surveyed.belief_set(run.beliefs)
        for place, (agent, label) in enumerate(surveyed.plans):
            if (run.plans & ~seen) >> place & 1:
                plans.setdefault(agent, {})[label] = list(beliefs)
        seen |= run.plans
    return plans


def _aims(name: str, product: CrossProduct, surveyed: Exploration) -> dict[Bin, tuple[str, ...]]:
    """What abstract tests aim at -> the smallest belief set found that does."""
    assert product.planned is not None
    found: dict[Bin, tuple[str, ...]] = {}
    size: int | None = None
    for run in surveyed.runs:
        for each in product.planned(run.lines):
            aim = tuple(each)
            if aim not in found:
                size = len(aim) if size is None else size
                _check(name, product, aim, size)
                found[aim] = surveyed.belief_set(run.beliefs)
    return found


def _check(name: str, product: CrossProduct, aim: Bin, size: int) -> None:
    kinds = [*islice(product.coordinates.items(), len(aim))]
    if len(aim) != size or not 0 < len(aim) <= len(product.coordinates):
        raise CoverError(f"cross product {name!r}: planned told {aim}; expected a bin of each of the same coordinates")
    for told, (coordinate, bins) in zip(aim, kinds, strict=True):
        if told not in bins:
            raise CoverError(f"cross product {name!r}: planned told {aim}, but {coordinate!r} has no bin {told!r}")


def _impossible(
    product: CrossProduct, aims: Mapping[Bin, tuple[str, ...]] | None, surveyed: Exploration
) -> dict[Bin, str]:
    """The bins that no run of the model aims at; none unless these are all runs."""
    if aims is None or not surveyed.complete:
        return {}
    size = max(map(len, aims), default=0)
    names = " x ".join(islice(product.coordinates, size))
    reason = f"none of the model's {len(surveyed.runs)} runs has this {names}"
    return {each: reason for each in product.bins() if each[:size] not in aims}
