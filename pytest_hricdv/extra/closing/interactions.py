"""The interactions of an abstract test: what each plans, which disturbances intervene in it, and its effect.

A cross product with `planned` says which combination of its first coordinates each interaction of a test plans. An
interaction begins with the command at which `planned` of the commands so far returns one combination more.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.generate.abstract import disturbance_line, disturbance_of
from pytest_hricdv.generate.chosen_values import Values

Planned = Callable[[Sequence[str]], Iterable[Bin]]


class Intervention(NamedTuple):
    """One disturbance in an interaction: after a number of its commands, with its parameters."""

    place: int
    name: str
    values: tuple[tuple[str, float], ...] = ()


RunValues = tuple[tuple[str, float], ...]
"""The parameters of a run as a whole, sorted."""

Combination = tuple[Intervention, ...]
"""The interventions in one interaction, in order."""

UNDISTURBED: Combination = ()


Outcome = tuple[str, ...]
"""The end of an interaction in one cross product: its name, and the unplanned coordinates of the bin."""

Effect = tuple[Outcome, ...]
"""The end of an interaction in all cross products, sorted."""


class PlannedInteraction(NamedTuple):
    """An interaction before it is run: a cross product, and the first coordinates of its bin."""

    product: str
    planned: Bin


class Interaction(NamedTuple):
    """One interaction of a run.

    Args:
        planned: the first coordinates of its bin.
        combination: its interventions.
        effect: how it ended.
        is_isolated: no earlier interaction of the run had interventions whose effects could carry over.
        wanted: the outcomes that its combination was to lead to.
        run_values: of its run.
    """

    planned: Bin
    combination: Combination
    effect: Effect
    is_isolated: bool = True
    wanted: tuple[Outcome, ...] = ()
    run_values: RunValues = ()


def commands_of(lines: Sequence[str]) -> tuple[str, ...]:
    """The commands of a test without its disturbances."""
    return tuple(line for line in lines if disturbance_of(line) is None)


def starts_of(commands: Sequence[str], planned: Planned) -> tuple[int, ...]:
    """The place of the first command of each interaction."""
    sizes = [len([*planned(commands[:place])]) for place in range(len(commands) + 1)]
    return tuple(place for place in range(len(commands)) for _ in range(sizes[place + 1] - sizes[place]))


def combinations_of(lines: Sequence[str], values: Values, starts: Sequence[int]) -> tuple[Combination, ...]:
    """The interventions in each interaction of a test.

    A disturbance right before the first command of an interaction belongs to the one before, if there is one.

    Args:
        lines: of the test.
        values: of the test.
        starts: where its interactions begin, among its commands.
    """
    interventions: list[list[Intervention]] = [[] for _ in starts]
    place = number = 0
    for row, line in enumerate(lines, 1):
        while number + 1 < len(starts) and place > starts[number + 1]:
            number += 1
        if (name := disturbance_of(line)) is None:
            place += 1
        elif starts:
            chosen = tuple(sorted(values.get(row, {}).items()))
            interventions[number].append(Intervention(place - starts[number], name, chosen))
    return tuple(map(tuple, interventions))


def insert_combinations(
    commands: Sequence[str], starts: Sequence[int], combinations: Sequence[Combination]
) -> tuple[tuple[str, ...], dict[int, dict[str, float]]]:
    """Lines and values of a test with these interventions in its interactions; the reverse of `combinations_of`."""
    at: dict[int, list[Intervention]] = {}
    for start, combination in zip(starts, combinations, strict=False):
        for intervention in combination:
            at.setdefault(min(max(start + intervention.place, 0), len(commands)), []).append(intervention)
    lines: list[str] = []
    values: dict[int, dict[str, float]] = {}
    for place in range(len(commands) + 1):
        for intervention in at.get(place, ()):
            lines.append(disturbance_line(intervention.name))
            if intervention.values:
                values[len(lines)] = dict(intervention.values)
        lines += commands[place : place + 1]
    return tuple(lines), values


def interactions_of(
    lines: Sequence[str], values: Values, hits: Mapping[str, Sequence[Bin]], product: str, planned: Planned
) -> tuple[Interaction, ...]:
    """The interactions of a run, as far as they have a bin of the cross product.

    A run may end before its test, and an interaction may have no bin: a bin belongs to the next interaction that
    plans its first coordinates. Other cross products are part of the effect where they have as many bins.

    Args:
        lines: of its test.
        values: of its test.
        hits: cross product -> the bins of its interactions, in their order.
        product: the cross product in question.
        planned: of this cross product.
    """
    commands, own = commands_of(lines), hits.get(product, ())
    combinations = combinations_of(lines, values, starts_of(commands, planned))
    plans = [tuple(coordinates) for coordinates in planned(commands)][: len(combinations)]
    alike = {name: bins for name, bins in hits.items() if len(bins) == len(own)}
    interactions = []
    for row, number in _match(plans, own):
        size = len(plans[number])
        effect = tuple(sorted((name, *bins[row][size if name == product else 0 :]) for name, bins in alike.items()))
        is_isolated = not any(combinations[:number])
        interactions.append(Interaction(plans[number], combinations[number], effect, is_isolated))
    return tuple(interactions)


def _match(plans: Sequence[Bin], hits: Sequence[Bin]) -> Iterator[tuple[int, int]]:
    """The row of each bin, with the number of the interaction that it belongs to."""
    begin = 0
    for row, hit in enumerate(hits):
        number = next((place for place in range(begin, len(plans)) if hit[: len(plans[place])] == plans[place]), None)
        if number is not None:
            begin = number + 1
            yield row, number
