"""Coverage of cross products as a report holds it: what was declared, what is impossible, and what was hit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from pytest_hricdv._base.record import Count, Names, PlainRecord


class Coordinate(PlainRecord, frozen=True, kw_only=True):
    """A coordinate of a cross product, with its bins."""

    name: str
    bins: Names


class ImpossibleBin(PlainRecord, frozen=True, kw_only=True):
    """A bin that cannot be hit: by declaration, or because the model cannot."""

    bin: Names
    reason: str
    by: Literal["declared", "model"]


class IllegalBin(PlainRecord, frozen=True, kw_only=True):
    """A bin that must not be hit."""

    bin: Names
    reason: str


class Proof(PlainRecord, frozen=True, kw_only=True):
    """Whether all runs of the model were explored; every field is None for a product without a model."""

    status: Literal["proven", "not proven"] | None = None
    reason: str | None = None
    runs: Count | None = None


class ProductDeclaration(PlainRecord, frozen=True, kw_only=True):
    """A cross product as the testbench declared it, with what the model rules out."""

    coordinates: tuple[Coordinate, ...]
    impossible: tuple[ImpossibleBin, ...]
    illegal: tuple[IllegalBin, ...]
    proof: Proof


class BinHits(PlainRecord, frozen=True, kw_only=True):
    """A bin that was hit: by how many tests, and how often."""

    bin: Names
    tests: Count
    hits: Count


class ProductCoverage(PlainRecord, frozen=True, kw_only=True):
    """A suite's coverage of one cross product. `missing` bins are possible, legal and not hit."""

    bins: Count
    hit: Count
    impossible: Count
    illegal: Count
    hits: tuple[BinHits, ...]
    missing: tuple[Names, ...]


class CrossCoverage(PlainRecord, frozen=True, kw_only=True):
    """A suite's coverage of all cross products: sums, missing bins as text, and each product."""

    bins: Count
    hit: Count
    impossible: Count
    illegal: Count
    missing: Names
    products: Mapping[str, ProductCoverage]

    @property
    def possible(self) -> int:
        """How many bins there are to cover."""
        return self.bins - self.impossible - self.illegal


class PlannedBin(PlainRecord, frozen=True, kw_only=True):
    """Bins of the first coordinates that a run of the model aims at, and the smallest belief set that leads to it."""

    bin: Names
    beliefs: Names


class ExplorationRecord(PlainRecord, frozen=True, kw_only=True):
    """The result of exploring all runs of the model; every field is None if nothing was explored.

    `plans` is agent -> plan -> the smallest belief set found that reaches it. `bins` is by cross product.
    """

    status: Literal["proven", "not proven"] | None = None
    reason: str | None = None
    runs: Count | None = None
    plans: Mapping[str, Mapping[str, Names]] | None = None
    bins: Mapping[str, tuple[PlannedBin, ...]] | None = None
