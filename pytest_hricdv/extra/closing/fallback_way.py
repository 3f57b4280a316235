"""The fallback: what the loop runs where no way knows what to try, so that it does not end before its budget.

First tests of the pool that were not run yet; then those again that were run least often, with other drawn parameters.
"""

from __future__ import annotations

from random import Random

from pytest_hricdv.extra.closing.archive import Archive
from pytest_hricdv.extra.closing.pool import Pool
from pytest_hricdv.extra.closing.way import Proposal
from pytest_hricdv.generate.rng import shuffled

UNTRIED = "untried"
REPEATED = "repeated"


class FallbackWay:
    """See the module.

    Args:
        pool: of abstract tests.
    """

    name = UNTRIED

    def __init__(self, pool: Pool) -> None:
        self._pool = pool

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Way`."""
        proposals = untried(self._pool, archive, UNTRIED, count, rng)
        if len(proposals) < count:
            proposals += self._repeated(archive, count - len(proposals), rng)
        return proposals

    def _repeated(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """Tests that were run, the least often run first; none that has done the same each time, to the bit."""
        records: dict[tuple[str, ...], list[str]] = {}
        for entry in archive.entries:
            if not entry.observation.error:
                records.setdefault(entry.test.lines, []).append(entry.observation.record_sha256)
        runs = [records.get(test.lines, []) for test in self._pool.tests]
        varying = [number for number, hashes in enumerate(runs) if len(hashes) == 1 or len(set(hashes)) > 1]
        chosen = sorted(shuffled(rng, varying), key=lambda number: len(runs[number]))[:count]
        return [Proposal(self._pool.draft(number), REPEATED) for number in chosen]


def untried(pool: Pool, archive: Archive, way: str, count: int, rng: Random) -> list[Proposal]:
    """Tests of the pool that were not run yet, of which nobody knows what they hit.

    Args:
        way: that they are proposed for.
    """
    tried = {entry.test.lines for entry in archive.entries}
    numbers = [number for number, test in enumerate(pool.tests) if test.lines not in tried]
    return [Proposal(pool.draft(number), way) for number in shuffled(rng, numbers)[:count]]
