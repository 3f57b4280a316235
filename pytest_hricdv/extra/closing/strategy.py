"""Search strategies: each proposes tests from the archive of all runs alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from random import Random
from typing import Protocol, TypeVar

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.archive import Archive
from pytest_hricdv.generate.abstract import AbstractDraft
from pytest_hricdv.generate.rng import pick_weighted

T = TypeVar("T")

CHOICES, PRESSURE = 4, 3
"""Number of best choices among which one is drawn, in proportion to this power of how good it is; see the package."""


@dataclass(frozen=True)
class Proposal:
    """A test that a strategy proposes to run.

    Args:
        draft: the test, with the values that are chosen for it.
        strategy: the name of the strategy that proposes it.
        targets: the points that it is to hit.
        is_online: the person decides during the run. The test is then what it became.
    """

    draft: AbstractDraft
    strategy: str
    targets: tuple[Point, ...] = ()
    is_online: bool = False


class Strategy(Protocol):
    """One search strategy."""

    @property
    def name(self) -> str:
        """The name in progress lines, reports and the choice among strategies."""

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """Propose at most `count` tests to run next; fewer, or none, if this strategy has nothing else to try.

        The result depends only on the archive and the random stream, not on earlier proposals. Only `rng.random()` is
        used (see `pytest_hricdv.generate.rng`).
        """


def draw_good(rng: Random, worth: Mapping[T, float]) -> T:
    """One of the best, drawn in favour of the better ones; among equal ones, the first are kept."""
    best = sorted(worth, key=lambda choice: -worth[choice])[:CHOICES]
    return pick_weighted(rng, {choice: worth[choice] ** PRESSURE for choice in best})
