"""Cross-product coverage: named coordinates with named bins; a hit is one bin of each."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import product

from pytest_hricdv.cover.source import CoverError

Bin = tuple[str, ...]

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too


@dataclass(frozen=True)
class CrossProduct:
    """A declared cross product.

    Args:
        coordinates: name -> its bins, for instance {"gpl": ("000", ...), "outcome": ("released", ...)}.
        impossible: combinations that cannot occur, each with the reason.

    Raises:
        CoverError: an empty coordinate, or an impossible bin that is not in the product.
    """

    coordinates: Mapping[str, tuple[str, ...]]
    impossible: Mapping[Bin, str]

    def __post_init__(self) -> None:
        for name, bins in self.coordinates.items():
            if not bins:
                raise CoverError(f"cross product: coordinate {name!r} has no bins")
        unknown = set(self.impossible) - set(self.bins())
        if unknown:
            raise CoverError(f"cross product: {min(unknown)} is declared impossible but is no bin of it")

    def bins(self) -> tuple[Bin, ...]:
        """All combinations, impossible ones included."""
        return tuple(product(*self.coordinates.values()))

    def check(self, hits: Iterable[Bin]) -> tuple[Bin, ...]:
        """The hits, each once and in order. Raises CoverError for a hit that is no bin or was declared impossible."""
        known = set(self.bins())
        found = sorted({tuple(hit) for hit in hits})
        for hit in found:
            if hit not in known:
                raise CoverError(f"cross product: {hit} is no bin; coordinates are {', '.join(self.coordinates)}")
            if hit in self.impossible:
                raise CoverError(f"cross product: {hit} was hit but is declared impossible: {self.impossible[hit]}")
        return tuple(found)
