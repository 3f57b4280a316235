"""What a suite hit of the declared cross products: hit, missing, impossible, illegal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

from pytest_hricdv.cover.cross import Bin, CrossProduct

Plain = dict[str, Any]
BY_DECLARATION, BY_MODEL = "declared", "model"


def list_product(product: CrossProduct, proof: Mapping[str, Any], by_model: Mapping[Bin, str]) -> Plain:
    """What a report holds of a declared cross product.

    Args:
        proof: what is known of the model (see `pytest_hricdv.closure.proving`).
        by_model: the bins that the model proves impossible, each with the reason.
    """
    ruled_out = {each: (reason, BY_DECLARATION) for each, reason in product.ruled_out.items()}
    ruled_out |= {each: (reason, BY_MODEL) for each, reason in by_model.items() if each not in ruled_out}
    return {
        "coordinates": [{"name": name, "bins": list(bins)} for name, bins in product.coordinates.items()],
        "impossible": [
            {"bin": list(each), "reason": reason, "by": by} for each, (reason, by) in sorted(ruled_out.items())
        ],
        "illegal": [{"bin": list(each), "reason": reason} for each, reason in sorted(product.forbidden.items())],
        "proof": dict(proof),
    }


def closure(listed: Mapping[str, Plain], entries: Iterable[Mapping[str, Any]]) -> Plain:
    """The cross products of a suite: each one, and all together.

    An illegal bin is none to cover. A bin that the model proves impossible and that is hit all the same, as by a test
    that no model made, counts as possible.
    """
    entries = list(entries)
    products = {name: _product(name, product, entries) for name, product in listed.items()}
    keys = ("bins", "hit", "impossible", "illegal")
    several = len(products) > 1
    missing = [
        (f"{name}: " if several else "") + " x ".join(each)
        for name, product in products.items()
        for each in product["missing"]
    ]
    sums = {key: sum(product[key] for product in products.values()) for key in keys}
    return {**sums, "missing": missing, "products": products}


def _product(name: str, listed: Plain, entries: Iterable[Mapping[str, Any]]) -> Plain:
    hits: Counter[Bin] = Counter()
    tests: Counter[Bin] = Counter()
    for entry in entries:
        told = [tuple(hit) for hit in entry.get("cross", {}).get(name, ())]
        hits.update(told)
        tests.update(set(told))
    coordinates = {each["name"]: tuple(each["bins"]) for each in listed["coordinates"]}
    bins = CrossProduct(coordinates).bins()
    illegal = {tuple(each["bin"]) for each in listed["illegal"]}
    impossible = {tuple(each["bin"]) for each in listed["impossible"]} - set(hits) - illegal
    return {
        "bins": len(bins),
        "hit": len(hits.keys() - illegal),
        "impossible": len(impossible),
        "illegal": len(illegal),
        "hits": [{"bin": list(each), "tests": tests[each], "hits": hits[each]} for each in sorted(hits)],
        "missing": [list(each) for each in bins if each not in hits and each not in impossible | illegal],
    }


def possible(cross: Mapping[str, Any]) -> int:
    """How many bins there are to cover."""
    return int(cross["bins"] - cross["impossible"] - cross.get("illegal", 0))
