"""Strategies of the closing loop that take undisturbed tests from the pool; `ClosureGenerator` uses both.

`ModelStrategy` aims at open bins and open plans. The chance that a test hits a bin is learned from earlier runs
(`experience`); which tests execute a plan is known from exploring the AgentSpeak model (`pool`). For open bins that no
known interaction leads to, it tries tests that have not been run.

`FallbackStrategy` fills a generation for which the other strategies propose too few tests: first with tests that have
not been run (`untried`), then with those whose runs differ from each other (`repeated`).
"""

from __future__ import annotations

from random import Random

from pytest_hricdv.extra.closing.experience import Experience
from pytest_hricdv.extra.closing.pool import UNDISTURBED, Combination, Outcome, PlannedInteraction, Pool
from pytest_hricdv.extra.closing.selection import Option, Selection
from pytest_hricdv.extra.closing.strategy import Archive, Proposal
from pytest_hricdv.generate.rng import pick, shuffle

MIN_CHANCE = 0.1
"""Smallest chance, learned from runs, at which a test aims at a bin; below it, a disturbance more probably hits it."""


class ModelStrategy:
    """Selects undisturbed tests of the pool that will probably hit open targets, by the experience of earlier runs."""

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
        outcomes = self._experience.models[interaction.product]
        options = [
            Option(outcomes.chance(interaction.planned, UNDISTURBED, outcome) * openness, (outcome,), _no_interventions)
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
    """Tests that have not been run; then, again, those whose runs differ.

    Args:
        pool: the abstract tests.
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
        """Tests that have been run, the least often run first, except those whose runs were all bit-identical."""
        records: dict[tuple[str, ...], list[str]] = {}
        for entry in archive.entries:
            if not entry.observation.error:
                records.setdefault(entry.test.lines, []).append(entry.observation.record_sha256)
        runs = [records.get(test.lines, []) for test in self._pool.tests]
        varying = [number for number, hashes in enumerate(runs) if len(hashes) == 1 or len(set(hashes)) > 1]
        chosen = sorted(shuffle(rng, varying), key=lambda number: len(runs[number]))[:count]
        return [Proposal(self._pool.draft(number), REPEATED) for number in chosen]


def fresh_tests(pool: Pool, archive: Archive, strategy: str, count: int, rng: Random) -> list[Proposal]:
    """Tests of the pool that have not been run; what they hit is unknown.

    Args:
        strategy: name of the strategy that proposes them.
    """
    tried = {entry.test.lines for entry in archive.entries}
    numbers = [number for number, test in enumerate(pool.tests) if test.lines not in tried]
    return [Proposal(pool.draft(number), strategy) for number in shuffle(rng, numbers)[:count]]
