"""The interactions of a script: what each plans, how it is disturbed, and what became of it.

A cross product with `planned` says which combination of its first coordinates each interaction of a script aims at. An
interaction begins with the command at which `planned` of the commands so far returns one combination more.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.disturbance import PREFIX
from pytest_hricdv.generate.chosen_values import Values

Planned = Callable[[Sequence[str]], Iterable[Bin]]


class Dose(NamedTuple):
    """A disturbance of an interaction: name, parameters, and how many of its commands come first."""

    place: int
    name: str
    values: tuple[tuple[str, float], ...] = ()


RunValues = tuple[tuple[str, float], ...]
"""The parameters of a run as a whole, sorted."""

Treatment = tuple[Dose, ...]
"""How an interaction is disturbed, in order."""

UNDISTURBED: Treatment = ()


Goal = tuple[str, ...]
"""What may come of an interaction: the name of a cross product and a bin of it, without the coordinates that were
planned."""

Effect = tuple[Goal, ...]
"""What came of an interaction, sorted."""


class Interaction(NamedTuple):
    """One interaction of a run.

    Args:
        planned: the first coordinates of its bin.
        treatment: how it was disturbed.
        effect: what came of it, by all cross products.
        is_clean: none before it was disturbed, so nothing lasts from there.
        aims: what its treatment was to lead to.
        run_values: of its run.
    """

    planned: Bin
    treatment: Treatment
    effect: Effect
    is_clean: bool = True
    aims: tuple[Goal, ...] = ()
    run_values: RunValues = ()


def commands_of(lines: Sequence[str]) -> tuple[str, ...]:
    """The commands of a test without its disturbances."""
    return tuple(line for line in lines if not line.startswith(PREFIX))


def treated(lines: Sequence[str]) -> bool:
    """Whether a test has a disturbance."""
    return any(line.startswith(PREFIX) for line in lines)


def begins(commands: Sequence[str], planned: Planned) -> tuple[int, ...]:
    """The place of the first command of each interaction."""
    sizes = [len([*planned(commands[:place])]) for place in range(len(commands) + 1)]
    return tuple(place for place in range(len(commands)) for _ in range(sizes[place + 1] - sizes[place]))


def treatments_of(lines: Sequence[str], values: Values, first: Sequence[int]) -> tuple[Treatment, ...]:
    """How each interaction of a test is disturbed.

    A disturbance right before the first command of an interaction belongs to the one before, if there is one.

    Args:
        lines: of the test.
        values: of the test.
        first: where its interactions begin, among its commands.
    """
    found: list[list[Dose]] = [[] for _ in first]
    place = number = 0
    for row, line in enumerate(lines, 1):
        while number + 1 < len(first) and place > first[number + 1]:
            number += 1
        if not line.startswith(PREFIX):
            place += 1
        elif first:
            chosen = tuple(sorted(values.get(row, {}).items()))
            found[number].append(Dose(place - first[number], line.removeprefix(PREFIX), chosen))
    return tuple(map(tuple, found))


def disturbed(
    commands: Sequence[str], first: Sequence[int], treatments: Sequence[Treatment]
) -> tuple[tuple[str, ...], dict[int, dict[str, float]]]:
    """Lines and values of a test whose interactions are disturbed like this; the reverse of `treatments_of`."""
    at: dict[int, list[Dose]] = {}
    for begin, treatment in zip(first, treatments, strict=False):
        for dose in treatment:
            at.setdefault(min(max(begin + dose.place, 0), len(commands)), []).append(dose)
    lines: list[str] = []
    values: dict[int, dict[str, float]] = {}
    for place in range(len(commands) + 1):
        for dose in at.get(place, ()):
            lines.append(f"{PREFIX}{dose.name}")
            if dose.values:
                values[len(lines)] = dict(dose.values)
        lines += commands[place : place + 1]
    return tuple(lines), values


def interactions_of(
    lines: Sequence[str], values: Values, hits: Mapping[str, Sequence[Bin]], product: str, planned: Planned
) -> tuple[Interaction, ...]:
    """The interactions of a run, as far as they have a bin of the cross product.

    A run may end before its script, and an interaction may have no bin: a bin belongs to the next interaction that
    plans its first coordinates. Other cross products tell what came of it where they have as many bins.

    Args:
        lines: of its test.
        values: of its test.
        hits: cross product -> the bins of its interactions, in their order.
        product: the cross product in question.
        planned: of this cross product.
    """
    commands, own = commands_of(lines), hits.get(product, ())
    treatments = treatments_of(lines, values, begins(commands, planned))
    script = [(tuple(each), treatment) for each, treatment in zip(planned(commands), treatments, strict=False)]
    alike = {name: bins for name, bins in hits.items() if len(bins) == len(own)}
    found = []
    for row, number in _matched([each for each, _ in script], own):
        each, treatment = script[number]
        effect = ((name, *bins[row][len(each) if name == product else 0 :]) for name, bins in alike.items())
        found.append(Interaction(each, treatment, tuple(sorted(effect)), not any(treatments[:number])))
    return tuple(found)


def _matched(planned: Sequence[Bin], hits: Sequence[Bin]) -> Iterator[tuple[int, int]]:
    """The row of each bin, with the number of the interaction that it belongs to."""
    begin = 0
    for row, hit in enumerate(hits):
        number = next((each for each in range(begin, len(planned)) if hit[: len(planned[each])] == planned[each]), None)
        if number is not None:
            begin = number + 1
            yield row, number
