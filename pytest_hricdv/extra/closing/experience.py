"""`Experience`: what the closing loop learns from its runs: how interactions end, which disturbances were tried where.

The strategies `model` and `disturbances` let it learn from the archive, and ask it for open outcomes. The *effect*
of an interaction, how it ended, is a tuple of outcomes, each a tuple of strings. `find_missing` compares an effect with
a wanted one: in strings of the same length, such as `1101` and `1001` for four sensors, each differing character is a
missing condition, and other differences may follow from these. If no characters differ, the whole effect is the
condition.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import chain
from typing import NamedTuple

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.extra.closing.outcome_model import OutcomeModel
from pytest_hricdv.extra.closing.pool import Effect, Outcome, PlannedInteraction, Pool, interactions_of
from pytest_hricdv.extra.closing.strategy import Archive
from pytest_hricdv.generate.abstract import disturbance_of


class CharacterCondition(NamedTuple):
    """A wanted character: index and length of its string in the effect, index in this string, and the character."""

    text: int
    size: int
    place: int
    wanted: str


class EffectCondition(NamedTuple):
    """An effect that is wanted instead of the present one."""

    present: Effect
    wanted: Effect


MissingCondition = CharacterCondition | EffectCondition


def find_missing(effect: Effect, wanted: Effect) -> tuple[MissingCondition, ...]:
    """What keeps an effect from being the wanted one."""
    characters = tuple(
        CharacterCondition(number, len(text), place, right)
        for number, (text, other) in enumerate(zip(chain(*effect), chain(*wanted), strict=False))
        if len(text) == len(other)
        for place, (left, right) in enumerate(zip(text, other, strict=True))
        if left != right
    )
    return characters or ((EffectCondition(effect, wanted),) if effect != wanted else ())


def effect_distance(effect: Effect, other: Effect) -> float:
    """The sum over all pairs of strings: the share of differing characters if the lengths are equal, else 1."""
    return sum(_text_distance(left, right) for left, right in zip(chain(*effect), chain(*other), strict=False))


def _text_distance(left: str, right: str) -> float:
    if left == right or len(left) != len(right):
        return float(left != right)
    return sum(a != b for a, b in zip(left, right, strict=True)) / len(left)


def character(effect: Effect, condition: CharacterCondition) -> str:
    """The character of the effect at the condition's index; empty if its string has another length."""
    texts = tuple(chain(*effect))
    is_alike = condition.text < len(texts) and len(texts[condition.text]) == condition.size
    return texts[condition.text][condition.place] if is_alike else ""


def are_comparable(effect: Effect, other: Effect) -> bool:
    """Whether two effects have outcomes of the same cross products."""
    return [outcome[0] for outcome in effect] == [outcome[0] for outcome in other]


AT_THE_START: Outcome = ("the start of a run",)
"""Replaces the nominal outcome before the first command, where a disturbance may have effects of its own."""


class Experience:
    """Statistics of an archive of runs."""

    def __init__(self, pool: Pool) -> None:
        self._pool = pool
        sizes = {interaction.product: len(interaction.planned) for interaction in pool.by_interaction}
        self.models: Mapping[str, OutcomeModel] = {name: OutcomeModel(sizes.get(name, 0)) for name in pool.planned}
        """Cross product -> the model of its interactions."""
        self.tries: Counter[tuple[str, Outcome | None]] = Counter()
        """(disturbance, nominal outcome of the interaction or None) -> number of tries as its only disturbance.
        The outcome is `AT_THE_START` before the first command."""
        self._learned = 0

    def learn(self, archive: Archive) -> None:
        """Learn from the runs that were added since the last call."""
        for entry in archive.entries[self._learned :]:
            test, hits = entry.test, entry.observation.hits
            for product, planned in self._pool.planned.items():
                interactions = interactions_of(test.lines, test.values, hits, product, planned)
                self.models[product].learn(interactions)
                for interaction in interactions:
                    if len(interaction.combination) == 1:  # of several, one may mask the effect of another
                        [intervention] = interaction.combination
                        nominal = self.nominal(PlannedInteraction(product, interaction.planned))
                        self._count(intervention.name, nominal, intervention.place)
            if not self._pool.planned:
                for name, place in _places(test.lines):
                    self._count(name, None, place)
        self._learned = len(archive.entries)

    def _count(self, name: str, nominal: Outcome | None, place: int) -> None:
        self.tries[name, nominal if place else AT_THE_START] += 1

    def nominal(self, interaction: PlannedInteraction) -> Outcome | None:
        """The most frequent outcome without disturbances, of the interaction's own cross product; None if unknown."""
        effect = self.models[interaction.product].nominal(interaction.planned) or ()
        return next((outcome for outcome in effect if outcome[0] == interaction.product), None)

    def open_outcomes(self, archive: Archive) -> dict[PlannedInteraction, dict[Outcome, Point]]:
        """The open outcomes: interaction -> outcome -> open bin.

        A bin that no test plans is listed for the interactions whose effects were nearest to it.
        """
        wanted: dict[PlannedInteraction, dict[Outcome, Point]] = {}
        for point in archive.open:
            if point[0] == "bin":
                for interaction, outcome in self._sources_of(point):
                    wanted.setdefault(interaction, {})[outcome] = point
        return wanted

    def has_unplanned_bins(self, archive: Archive) -> bool:
        """Whether there is an open bin that no known interaction is likely to reach."""
        return any(point[0] == "bin" and not self._sources_of(point) for point in archive.open)

    def _sources_of(self, point: Point) -> list[tuple[PlannedInteraction, Outcome]]:
        product, own = point[1], self.models.get(point[1])
        if own is None:
            return self._nearest(point[1:])
        interaction = PlannedInteraction(product, point[2 : 2 + own.coordinates])
        outcome = product, *point[2 + own.coordinates :]
        return [(interaction, outcome)] if interaction in self._pool.by_interaction else []

    def _nearest(self, outcome: Outcome) -> list[tuple[PlannedInteraction, Outcome]]:
        near: dict[float, list[PlannedInteraction]] = {}
        for product, model in self.models.items():
            for planned, effects in model.effects.items():
                distances = [
                    effect_distance((seen,), (outcome,))
                    for effect in effects
                    for seen in effect
                    if seen[0] == outcome[0]
                ]
                interaction = PlannedInteraction(product, planned)
                if distances and interaction in self._pool.by_interaction:
                    near.setdefault(min(distances), []).append(interaction)
        return [(interaction, outcome) for interaction in near[min(near)]] if near else []


def _places(lines: Sequence[str]) -> list[tuple[str, int]]:
    """The disturbances of a test, each with the number of commands before it."""
    places, place = [], 0
    for line in lines:
        if (name := disturbance_of(line)) is not None:
            places.append((name, place))
        else:
            place += 1
    return places
