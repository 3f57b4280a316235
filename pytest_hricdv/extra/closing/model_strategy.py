"""The strategy `model`: undisturbed tests of the pool that, as exploring the model has shown, lead to open targets.

Bins are reached by tests that plan them, plans by beliefs that trigger them. Where bins are open of which it is unknown
what plans them, tests are tried that were not run yet.
"""

from __future__ import annotations

from random import Random

from pytest_hricdv.extra.closing.experience import Experience
from pytest_hricdv.extra.closing.pool import UNDISTURBED, Combination, Outcome, PlannedInteraction, Pool
from pytest_hricdv.extra.closing.selection import Option, Selection
from pytest_hricdv.extra.closing.strategy import Archive, Proposal
from pytest_hricdv.generate.rng import pick, shuffle

MIN_CHANCE = 0.1
"""Smallest chance with which a bin is aimed at: with less, disturbances are more certain to lead there."""


class ModelStrategy:
    """Selects undisturbed tests that probably hit open targets.

    Args:
        pool: of abstract tests.
        experience: of all runs so far.
    """

    name = "model"

    def __init__(self, pool: Pool, experience: Experience) -> None:
        self._pool = pool
        self._experience = experience

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Strategy`."""
        if not self._pool.tests:
            return []
        self._experience.learn(archive)
        selection = Selection(self._pool, self._experience, archive, self._options)
        proposals: list[Proposal] = []
        for _ in range(count):
            selected = selection.select(rng)
            if selected is not None:
                proposals.append(Proposal(self._pool.draft(selected.test), self.name, selected.targets))
            elif (proposal := self._for_plan(archive, proposals, rng)) is not None:
                proposals.append(proposal)
        if len(proposals) < count and self._experience.has_unplanned_bins(archive):
            proposals += fresh_tests(self._pool, archive, self.name, count - len(proposals), rng)
        return proposals

    def _options(self, interaction: PlannedInteraction, wanted: dict[Outcome, float]) -> list[Option]:
        model = self._experience.models[interaction.product]
        options = [
            Option(model.chance(interaction.planned, UNDISTURBED, outcome) * openness, (outcome,), _no_interventions)
            for outcome, openness in wanted.items()
        ]
        return sorted((option for option in options if option.gain >= MIN_CHANCE), key=lambda option: -option.gain)

    def _for_plan(self, archive: Archive, proposals: list[Proposal], rng: Random) -> Proposal | None:
        """A test for an open plan."""
        targeted = {target for proposal in proposals for target in proposal.targets}
        for point in archive.open:
            tests = self._pool.by_plan.get((point[1], point[2]), []) if point[0] == "plan" else []
            if tests and point not in targeted:
                return Proposal(self._pool.draft(pick(rng, tests)), self.name, (point,))
        return None


def _no_interventions(commands: int, is_first: bool) -> Combination:
    return UNDISTURBED


UNTRIED = "untried"
REPEATED = "repeated"


class FallbackStrategy:
    """Tests that were not run yet; then again those whose runs differ.

    Args:
        pool: of abstract tests.
    """

    name = UNTRIED

    def __init__(self, pool: Pool) -> None:
        self._pool = pool

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Strategy`."""
        proposals = fresh_tests(self._pool, archive, UNTRIED, count, rng)
        if len(proposals) < count:
            proposals += self._repeat_tests(archive, count - len(proposals), rng)
        return proposals

    def _repeat_tests(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """Tests that were run, the least often run first; none that has done the same each time, bit by bit."""
        records: dict[tuple[str, ...], list[str]] = {}
        for entry in archive.entries:
            if not entry.observation.error:
                records.setdefault(entry.test.lines, []).append(entry.observation.record_sha256)
        runs = [records.get(test.lines, []) for test in self._pool.tests]
        varying = [number for number, hashes in enumerate(runs) if len(hashes) == 1 or len(set(hashes)) > 1]
        chosen = sorted(shuffle(rng, varying), key=lambda number: len(runs[number]))[:count]
        return [Proposal(self._pool.draft(number), REPEATED) for number in chosen]


def fresh_tests(pool: Pool, archive: Archive, strategy: str, count: int, rng: Random) -> list[Proposal]:
    """Tests of the pool that have not run yet; what they hit is unknown.

    Args:
        strategy: that they are proposed for.
    """
    tried = {entry.test.lines for entry in archive.entries}
    numbers = [number for number, test in enumerate(pool.tests) if test.lines not in tried]
    return [Proposal(pool.draft(number), strategy) for number in shuffle(rng, numbers)[:count]]
