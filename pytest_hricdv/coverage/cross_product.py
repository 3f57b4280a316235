"""Cross products, which testbenches declare: a bin is a combination of one value of each coordinate; runs hit bins.

`CrossProduct` is the declaration; each run of a test checks its hits against it. The records at the end of the module,
from `Coordinate` on, say in a report what was declared, what is impossible, and what was hit.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from math import prod
from typing import Literal

from pytest_hricdv._base.record import Count, Names, PlainRecord
from pytest_hricdv.coverage.code_map import CoverageError

Bin = tuple[str, ...]

ANY = "*"
"""Stands for every value of a coordinate."""
MAX_BINS = 100_000
"""Most bins of one cross product: a report lists every bin, and 100,000 of four coordinates are 4 MB of JSON."""

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too


@dataclass(frozen=True)
class CheckedHits:
    """The hits of a run in order, except impossible ones; and what is wrong with them, a sentence each."""

    bins: tuple[Bin, ...]
    faults: tuple[str, ...]


@dataclass(frozen=True)
class CrossProduct:
    """A declared cross product.

    A coordinate that has the name of a requirement (with values among Passed, Failed, NC) is filled in from the
    requirement's verdict on the run; the others are reported by the testbench's `run`.

    Args:
        coordinates: name -> its values, for instance {"gpl": ("000", ...), "outcome": ("released", ...)}.
        impossible: combinations that cannot occur, each with the reason; "*" stands for any value of a coordinate.
        illegal: combinations that must not occur, each with the reason: a test that hits one fails. "*" as above.
        planned: from the lines of an abstract test, the combinations of the first coordinates that it aims at.
            If the model is small enough to explore, what it plans with no belief set is impossible.

    Raises:
        CoverageError: no or an empty coordinate, a value twice, too many bins, or a combination that is not a bin.

    A lift that carries a nurse or a child to one of two floors, where no child may go to the roof, and the verdict of
    requirement R1:

    >>> rides = CrossProduct(
    ...     {"rider": ("nurse", "child"), "floor": ("ward", "roof"), "R1": ("Passed", "Failed", "NC")},
    ...     illegal={("child", "roof", "*"): "children stay inside"},
    ... )
    >>> len(rides.bins())
    12

    A run reports the other coordinates, in their order, once for each hit (see `Outcome.cross`); the verdict is added:

    >>> rides.check([("nurse", "ward"), ("nurse", "roof")], {"R1": "Passed"}).bins
    (('nurse', 'roof', 'Passed'), ('nurse', 'ward', 'Passed'))
    >>> rides.check([("nurse", "cellar")], {"R1": "NC"}).faults
    ("('nurse', 'cellar') is not a bin; coordinates are rider, floor",)
    """

    coordinates: Mapping[str, tuple[str, ...]]
    impossible: Mapping[Bin, str] = field(default_factory=dict)
    illegal: Mapping[Bin, str] = field(default_factory=dict)
    planned: Callable[[Sequence[str]], Iterable[Bin]] | None = None

    def __post_init__(self) -> None:
        if not self.coordinates:
            raise CoverageError("cross product: expected at least one coordinate")
        for name, bins in self.coordinates.items():
            if not bins or isinstance(bins, str):
                raise CoverageError(f"cross product: coordinate {name!r} has {bins!r}; expected a tuple of values")
            if len(set(bins)) != len(bins) or ANY in bins:
                raise CoverageError(
                    f"cross product: coordinate {name!r} has a value twice, or one named {ANY!r}: {bins}"
                )
        if prod(map(len, self.coordinates.values())) > MAX_BINS:
            raise CoverageError(f"cross product of {', '.join(self.coordinates)}: more than {MAX_BINS} bins")
        for kind, patterns in (("impossible", self.impossible), ("illegal", self.illegal)):
            for pattern in patterns:
                if not any(True for _ in self._matches(pattern)):
                    raise CoverageError(f"cross product: {pattern} is declared {kind} but is not a bin of it")

    def bins(self) -> tuple[Bin, ...]:
        """All combinations, impossible ones included."""
        return tuple(product(*self.coordinates.values()))

    @cached_property
    def impossible_bins(self) -> dict[Bin, str]:
        """Every bin that is declared impossible -> the reason."""
        return self._spread(self.impossible)

    @cached_property
    def forbidden(self) -> dict[Bin, str]:
        """Every bin that is declared illegal -> the reason."""
        return self._spread(self.illegal)

    def check(self, hits: Iterable[Bin], verdicts: Mapping[str, str]) -> CheckedHits:
        """The hits that a run reported, with the verdict at every coordinate that is named after a requirement.

        A hit that is not a bin, or that was declared impossible, is left out.
        """
        bins: list[Bin] = []
        faults: set[str] = set()
        for reported in hits:
            hit = self._with_verdicts(tuple(reported), verdicts)
            if hit is None:
                names = ", ".join(name for name in self.coordinates if name not in verdicts)
                faults.add(f"{tuple(reported)} is not a bin; coordinates are {names}")
            elif hit in self.impossible_bins:
                faults.add(f"{' x '.join(hit)} was hit but is declared impossible: {self.impossible_bins[hit]}")
            else:
                bins.append(hit)
                if hit in self.forbidden:
                    faults.add(f"{' x '.join(hit)} must not be hit: {self.forbidden[hit]}")
        return CheckedHits(tuple(sorted(bins)), tuple(sorted(faults)))

    def _with_verdicts(self, hit: Bin, verdicts: Mapping[str, str]) -> Bin | None:
        """The hit, completed; None if it is not a bin."""
        if len(hit) != sum(name not in verdicts for name in self.coordinates):
            return None
        rest = iter(hit)
        complete = tuple(verdicts[name] if name in verdicts else next(rest) for name in self.coordinates)
        kinds = self.coordinates.values()
        return complete if all(part in bins for part, bins in zip(complete, kinds, strict=True)) else None

    def _spread(self, patterns: Mapping[Bin, str]) -> dict[Bin, str]:
        reasons: dict[Bin, str] = {}
        for pattern, reason in patterns.items():
            for bin_ in self._matches(pattern):
                reasons.setdefault(bin_, reason)
        return reasons

    def _matches(self, pattern: Bin) -> Iterable[Bin]:
        kinds = tuple(self.coordinates.values())
        if len(pattern) != len(kinds):
            return ()
        allowed = [
            bins if part == ANY else (part,) if part in bins else () for part, bins in zip(pattern, kinds, strict=True)
        ]
        return product(*allowed)


class Coordinate(PlainRecord, frozen=True, kw_only=True):
    """A coordinate of a cross product, with its values."""

    name: str
    bins: Names


class ImpossibleBin(PlainRecord, frozen=True, kw_only=True):
    """A bin that cannot be hit: by declaration, or because no run of the model plans it."""

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
    """A combination of the first coordinates that a run of the model plans, and the smallest belief set that leads to
    it."""

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
